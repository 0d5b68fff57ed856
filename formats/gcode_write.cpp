// G-code that LinuxCNC's interpreter (rs274) accepts: one move a line, no exponents, modal words
// first.
// SPDX-License-Identifier: Apache-2.0
#include "formats/path_formats.h"
#include "formats/path_text.h"

namespace diesink {
namespace {

std::string fixed(double value, int decimals) {
  std::array<char, 64> text;
  return {text.data(), put_fixed(text.data(), value, decimals)};
}

// No parentheses inside a comment.
std::string comment(std::string_view text) {
  std::string out;
  for (const char c : text.substr(0, 120))
    out += c < ' ' || c > '~' || c == '(' || c == ')' ? '_' : c;
  return out;
}

class GcodeText final : public PathText {
 public:
  void begin(const ToolPath& path, const PathWriteOptions& options, ByteWriter& out) override {
    const bool inch = path.unit == LengthUnit::kInch;
    decimals_ = path_decimals(path);
    out << "(" << comment(path.name) << ")\n(" << comment(options.program_comment) << ")\n";
    if (path.cutter) {
      out << "(CUTTER D=" << fixed(path.cutter->diameter, 9)
          << " R=" << fixed(path.cutter->corner_radius, 9) << ")\n";
    }
    out << "(INTOL=" << fixed(path.intol, 9) << " OUTTOL=" << fixed(path.outtol, 9) << ")\n";
    out << "G17 " << (inch ? "G20" : "G21") << " G40 G49 G54 G80 G90 G94\n";
    if (const double blend = blend_tolerance(path); blend > 0) {
      out << "G64 P" << fixed(blend, 9) << " Q0\n";  // Q0: no move is left out
    } else {
      out << "G61\n";
    }
    out << "T" << std::to_string(path.tool_number) << " M6\n";
    spindle_ = path.spindle > 0;
    if (spindle_) out << "S" << fixed(path.spindle, 3) << " M3\n";
    if (path.feed > 0) out << "F" << fixed(path.feed, 3) << '\n';
  }

  void point(const ClPoint& point, ByteWriter& out) override {
    // Wherever the machine stands, up comes before across.
    if (first_ && point.motion == Motion::kRapid) {
      out << "G0 Z" << fixed(point.tip.z(), decimals_) << '\n';
    }
    first_ = false;
    std::array<char, 8 + 3 * (kMaxNumberText + 24)> text;
    char* at = text.data();
    const int code = point.motion == Motion::kRapid ? 0 : 1;
    if (code != motion_) {
      *at++ = 'G';
      *at++ = static_cast<char>('0' + code);
      motion_ = code;
    }
    bool moves = false;
    for (std::size_t k = 0; k < 3; ++k) {
      std::array<char, 64> number;
      const std::string_view word(
          number.data(),
          static_cast<std::size_t>(
              put_fixed(number.data(), point.tip[static_cast<int>(k)], decimals_) - number.data()));
      if (word == last_[k]) continue;
      last_[k].assign(word);
      if (at != text.data()) *at++ = ' ';
      *at++ = static_cast<char>('X' + static_cast<int>(k));
      at = std::copy(word.begin(), word.end(), at);
      moves = true;
    }
    if (!moves) {
      motion_ = at == text.data() ? motion_ : -1;
      return;
    }
    *at++ = '\n';
    out << std::string_view(text.data(), static_cast<std::size_t>(at - text.data()));
  }

  void end(ByteWriter& out) override {
    if (spindle_) out << "M5\n";
    out << "M2\n";
  }

 private:
  int decimals_ = 6, motion_ = -1;
  bool spindle_ = false, first_ = true;
  std::array<std::string, 3> last_;
};

}  // namespace

std::unique_ptr<PathText> gcode_text() { return std::make_unique<GcodeText>(); }

}  // namespace diesink
