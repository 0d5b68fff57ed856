// APT CL-data as post-processors read it: 72 columns, fixed notation, no blank after the slash.
// SPDX-License-Identifier: Apache-2.0
#include "formats/path_formats.h"
#include "formats/path_text.h"

namespace diesink {
namespace {

constexpr std::size_t kColumns = 72;

std::string fixed(double value, int decimals) {
  std::array<char, 64> text;
  char* const end = put_fixed(text.data(), value, decimals);
  std::string word(text.data(), end);
  // A number without a point is a counter to some post-processors.
  if (word.find('.') == std::string::npos) word += '.';
  return word;
}

// Letters a post-processor's printer knows.
std::string plain(std::string_view text) {
  std::string out = upper_case(text);
  for (char& c : out) {
    if (c < ' ' || c > '~' || c == '$') c = ' ';
  }
  return out;
}

void statement(ByteWriter& out, const std::string& text) {
  // A statement goes on behind a $ in the last column.
  std::string_view rest = text;
  while (rest.size() > kColumns) {
    std::size_t cut = rest.substr(0, kColumns - 1).rfind(',');
    cut = cut == std::string_view::npos ? kColumns - 1 : cut + 1;
    out << rest.substr(0, cut) << "$\n";
    rest.remove_prefix(cut);
  }
  out << rest << '\n';
}

class AptText final : public PathText {
 public:
  void begin(const ToolPath& path, const PathWriteOptions& options, ByteWriter& out) override {
    const bool inch = path.unit == LengthUnit::kInch;
    decimals_ = path_decimals(path);
    const AptFlavour flavour = options.flavour;
    const std::string_view feed_unit = inch ? "IPM" : "MMPM";
    statement(out, ("PARTNO " + plain(path.name)).substr(0, kColumns));
    statement(out, ("$$ " + plain(options.program_comment)).substr(0, kColumns));
    statement(out, inch ? "UNITS/INCHES" : "UNITS/MM");
    if (path.intol > 0) statement(out, "INTOL/" + fixed(path.intol, 9));
    if (path.outtol > 0) statement(out, "OUTTOL/" + fixed(path.outtol, 9));
    if (path.cutter) {
      const double d = path.cutter->diameter, r = path.cutter->corner_radius;
      statement(out, "CUTTER/" + fixed(d, 9) + "," + fixed(r, 9) + "," + fixed(d / 2 - r, 9) + "," +
                         fixed(r, 9) + ",0.,0.," + fixed(4 * d, 9));
    }
    const std::string tool = std::to_string(path.tool_number);
    statement(out, flavour == AptFlavour::kNx ? "LOAD/TOOL," + tool : "LOADTL/" + tool);
    spindle_ = path.spindle > 0;
    if (spindle_) {
      const std::string speed = fixed(path.spindle, 3);
      const bool unit_first = flavour == AptFlavour::kNx || flavour == AptFlavour::kCreo;
      statement(out, unit_first ? "SPINDL/RPM," + speed + ",CLW" : "SPINDL/" + speed + ",RPM,CLW");
    }
    if (path.feed > 0) {
      const std::string feed = fixed(path.feed, 3);
      feed_ = flavour == AptFlavour::kNx ? "FEDRAT/" + std::string(feed_unit) + "," + feed
                                         : "FEDRAT/" + feed + "," + std::string(feed_unit);
    }
  }

  void point(const ClPoint& point, ByteWriter& out) override {
    if (point.motion == Motion::kRapid) {
      out << "RAPID\n";
      rapid_ = true;
    } else if (rapid_) {
      if (!feed_.empty()) statement(out, feed_);
      rapid_ = false;
    }
    std::array<char, 3 * (kMaxNumberText + 24)> text;
    char* at = text.data();
    for (int k = 0; k < 3; ++k) {
      if (k > 0) *at++ = ',';
      char* const begin = at;
      at = put_fixed(at, point.tip[k], decimals_);
      if (std::string_view(begin, static_cast<std::size_t>(at - begin)).find('.') ==
          std::string_view::npos) {
        *at++ = '.';
      }
    }
    out << "GOTO/" << std::string_view(text.data(), static_cast<std::size_t>(at - text.data()))
        << '\n';
  }

  void end(ByteWriter& out) override {
    if (spindle_) out << "SPINDL/OFF\n";
    out << "FINI\n";
  }

 private:
  int decimals_ = 6;
  bool spindle_ = false, rapid_ = true;
  std::string feed_;
};

}  // namespace

std::unique_ptr<PathText> apt_text() { return std::make_unique<AptText>(); }

}  // namespace diesink
