// A tool path as CSV: a head of comments, then `x,y,z,motion`.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
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

std::optional<double> head_number(std::string_view word) {
  const std::optional<double> value = number_of(without_blanks(word));
  return value && *value >= 0 && *value <= kLargestPathNumber ? value : std::nullopt;
}

std::optional<Cutter> head_cutter(std::string_view words) {
  const std::size_t comma = std::min(words.find(','), words.size());
  const std::optional<double> d = head_number(words.substr(0, comma));
  const std::optional<double> r = head_number(words.substr(std::min(comma + 1, words.size())));
  if (!d || !r || !(*d > 0) || *r > *d / 2 * (1 + 1e-9)) return std::nullopt;
  return Cutter{*d, *r};
}

// A comment of the head; others mean nothing.
void take_head(PathLines& lines, ToolPath& path) {
  const std::string_view text = without_blanks(without_blanks(lines.line()).substr(1));
  const std::size_t blank = std::min(text.find(' '), text.size());
  const std::string_view word = text.substr(0, blank), rest = without_blanks(text.substr(blank));
  if (word == "unit") {
    path.unit = rest == "inch" ? LengthUnit::kInch : LengthUnit::kMillimetre;
    if (rest != name_of(path.unit)) {
      lines.error(1, "'" + std::string(rest.substr(0, 40)) + "' is no unit; expected mm or inch");
    }
    return;
  }
  const std::array numbers{std::pair{"intol", &path.intol}, std::pair{"outtol", &path.outtol},
                           std::pair{"feed", &path.feed}, std::pair{"spindle", &path.spindle}};
  const auto* const number = std::find_if(numbers.begin(), numbers.end(),
                                          [&](const auto& known) { return word == known.first; });
  const bool is_number = number != numbers.end();
  if (word != "cutter" && !is_number) return;
  const std::optional<double> value = head_number(rest);
  const std::optional<Cutter> cutter = head_cutter(rest);
  if (is_number && value) *number->second = *value;
  if (!is_number && cutter) path.cutter = cutter;
  if (is_number ? !value : !cutter) {
    lines.warning(1, "states no " + std::string(word) + ", passed over; expected '# " +
                         std::string(word) + (is_number ? " NUMBER'" : " DIAMETER,CORNER'"));
  }
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
      take_head(lines, path);
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
