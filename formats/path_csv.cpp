// A tool path as CSV: a head of comments, then `x,y,z,motion`.
// SPDX-License-Identifier: Apache-2.0
#include <optional>
#include <vector>

#include "formats/path_formats.h"
#include "formats/path_text.h"

namespace diesink {
namespace {

struct Field {
  std::string_view text;
  std::size_t column = 1;
};

void split(std::string_view line, std::vector<Field>& fields) {
  fields.clear();
  std::size_t begin = 0;
  while (true) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    std::string_view text = line.substr(begin, end - begin);
    std::size_t column = begin + 1;
    while (!text.empty() && is_blank(text.front())) {
      text.remove_prefix(1);
      ++column;
    }
    fields.push_back({without_blanks(text), column});
    if (end == line.size()) return;
    begin = end + 1;
  }
}

void head(std::string_view text, ToolPath& path) {
  text = without_blanks(text);
  const std::size_t blank = text.find(' ');
  const std::string_view word = text.substr(0, blank);
  const std::string_view rest =
      blank == std::string_view::npos ? std::string_view{} : without_blanks(text.substr(blank));
  const std::optional<double> value = number_of(rest.substr(0, rest.find(',')));
  if (word == "unit") path.unit = rest == "inch" ? LengthUnit::kInch : LengthUnit::kMillimetre;
  if (!value) return;
  if (word == "cutter" && rest.find(',') != std::string_view::npos) {
    const std::optional<double> r = number_of(rest.substr(rest.find(',') + 1));
    if (r && *value > 0 && *r >= 0 && *r <= *value / 2 * (1 + 1e-9))
      path.cutter = Cutter{*value, *r};
  }
  if (word == "intol") path.intol = *value;
  if (word == "outtol") path.outtol = *value;
  if (word == "feed") path.feed = *value;
  if (word == "spindle") path.spindle = *value;
}

class CsvText final : public PathText {
 public:
  void begin(const ToolPath& path, const PathWriteOptions&, ByteWriter& out) override {
    out << "# unit " << name_of(path.unit) << '\n';
    if (path.cutter) {
      out << "# cutter " << path.cutter->diameter << ',' << path.cutter->corner_radius << '\n';
    }
    out << "# intol " << path.intol << "\n# outtol " << path.outtol << '\n';
    if (path.feed > 0) out << "# feed " << path.feed << '\n';
    if (path.spindle > 0) out << "# spindle " << path.spindle << '\n';
    out << "x,y,z,motion\n";
  }
  void point(const ClPoint& point, ByteWriter& out) override {
    out << point.tip.x() << ',' << point.tip.y() << ',' << point.tip.z()
        << (point.motion == Motion::kRapid ? ",rapid\n" : ",feed\n");
  }
  void end(ByteWriter&) override {}
};

}  // namespace

std::unique_ptr<PathText> path_csv_text() { return std::make_unique<CsvText>(); }

void read_path_csv(TextSource& text, const std::string& file_name, ToolPath& path,
                   PointsRead& points, Diagnostics& diagnostics) {
  PathLines lines(text, file_name, diagnostics);
  std::vector<Field> fields;
  std::array<std::size_t, 3> columns{0, 1, 2};
  std::size_t motion = 3, count = 0;
  while (lines.next()) {
    const std::string_view line = without_blanks(lines.line());
    if (line.empty()) continue;
    if (line[0] == '#') {
      head(line.substr(1), path);
      continue;
    }
    split(lines.line(), fields);
    if (count == 0) {
      count = fields.size();
      motion = count;
      std::array<bool, 3> named{false, false, false};
      for (std::size_t k = 0; k < count; ++k) {
        const std::string name = upper_case(fields[k].text);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          if (name == std::string(1, static_cast<char>('X' + static_cast<int>(axis)))) {
            columns[axis] = k;
            named[axis] = true;
          }
        }
        if (name == "MOTION") motion = k;
      }
      if (named[0] && named[1] && named[2]) continue;
      columns = {0, 1, 2};
      motion = 3;
      if (count < 3) {
        lines.error(1, "expected x,y,z or x,y,z,motion");
        return;
      }
    }
    if (fields.size() != count) {
      lines.error(1, std::to_string(fields.size()) + " fields; expected " + std::to_string(count));
      continue;
    }
    ClPoint point;
    bool good = true;
    for (std::size_t axis = 0; axis < 3 && good; ++axis) {
      const Field& field = fields[columns[axis]];
      double value = 0;
      good = lines.number(field.text, field.column, value);
      point.tip[static_cast<int>(axis)] = value;
    }
    if (!good) continue;
    if (motion < count) {
      const std::string word = upper_case(fields[motion].text);
      if (word == "RAPID" || word == "0") {
        point.motion = Motion::kRapid;
      } else if (word != "FEED" && word != "1") {
        lines.error(fields[motion].column,
                    "'" + word.substr(0, 40) + "' is no motion; expected rapid or feed");
        continue;
      }
    }
    points.add(point.tip, point.motion);
  }
}

}  // namespace diesink
