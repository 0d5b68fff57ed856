// G-code of straight moves: words and modal state of RS274/NGC as far as a three-axis path needs
// it. SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <optional>

#include "formats/path_formats.h"
#include "formats/path_text.h"

namespace diesink {
namespace {

class GcodeReader {
 public:
  GcodeReader(TextSource& text, const std::string& file_name, ToolPath& path, PointsRead& points,
              Diagnostics& diagnostics)
      : lines_(text, file_name, diagnostics), path_(path), points_(points) {}

  void read() {
    path_.unit = LengthUnit::kMillimetre;
    while (!finished_ && lines_.next()) block();
  }

 private:
  // `D=6 R=3` and the like in our own comments.
  static std::optional<double> tagged(std::string_view text, std::string_view tag) {
    const std::size_t at = text.find(tag);
    if (at == std::string_view::npos) return std::nullopt;
    std::string_view rest = text.substr(at + tag.size());
    return number_of(rest.substr(0, rest.find(' ')));
  }

  void comment(std::string_view text) {
    if (text.substr(0, 7) == "CUTTER ") {
      const std::optional<double> d = tagged(text, "D="), r = tagged(text, "R=");
      if (d && r && *d > 0 && *r >= 0 && *r <= *d / 2 * (1 + 1e-9)) path_.cutter = Cutter{*d, *r};
    } else if (text.substr(0, 6) == "INTOL=") {
      path_.intol = tagged(text, "INTOL=").value_or(0);
      path_.outtol = tagged(text, "OUTTOL=").value_or(0);
    }
  }

  bool g_code(double code, std::size_t column) {
    const int tenths = static_cast<int>(std::lround(code * 10));
    switch (tenths) {
      case 0:
        motion_ = Motion::kRapid;
        return true;
      case 10:
        motion_ = Motion::kFeed;
        return true;
      case 200:
        return unit(LengthUnit::kInch, column);
      case 210:
        return unit(LengthUnit::kMillimetre, column);
      case 900:
        relative_ = false;
        return true;
      case 910:
        relative_ = true;
        return true;
      case 40:
        dwell_ = true;
        return true;
      case 800:
        motion_.reset();
        return true;
      case 170:
      case 400:
      case 490:
      case 540:
      case 610:
      case 611:
      case 640:
      case 940:
      case 911:
      case 980:
      case 990:
      case 970:
        return true;
      default:
        lines_.error(
            column,
            "G" + std::to_string(code).substr(0, std::to_string(code).find_last_not_of("0.") + 1) +
                " is not supported; expected straight moves: G0 and G1, G17, G20, G21, "
                "G40, G49, G54, G61, G64, G80, G90, G91, G94");
        return false;
    }
  }

  bool unit(LengthUnit unit, std::size_t column) {
    if (unit != path_.unit && points_.count() > 0) {
      lines_.error(column, "the unit changes within the path");
      return false;
    }
    path_.unit = unit;
    return true;
  }

  void block() {
    const std::string_view line = lines_.line();
    std::array<std::optional<double>, 3> axis;
    dwell_ = false;
    bool good = true, first_word = true, move_word = false;
    std::size_t axis_column = 1;
    for (std::size_t k = 0; k < line.size() && good;) {
      const char c =
          line[k] >= 'a' && line[k] <= 'z' ? static_cast<char>(line[k] - 'a' + 'A') : line[k];
      if (is_blank(c) || c == '%' || (c == '/' && first_word)) {
        ++k;
        continue;
      }
      if (c == ';') {
        comment(line.substr(k + 1));
        break;
      }
      if (c == '(') {
        const std::size_t end = line.find(')', k);
        if (end == std::string_view::npos) {
          lines_.error(k + 1, "a comment without its ')'");
          return;
        }
        comment(line.substr(k + 1, end - k - 1));
        k = end + 1;
        continue;
      }
      if (c < 'A' || c > 'Z') {
        lines_.error(k + 1, c == '#' ? std::string("a variable (#) is not supported")
                                     : std::string("expected a letter and a number"));
        return;
      }
      const std::size_t column = k + 1;
      std::size_t end = ++k;
      while (end < line.size() &&
             (std::string_view("+-.0123456789 \t").find(line[end]) != std::string_view::npos)) {
        ++end;
      }
      std::string word;
      for (const char d : line.substr(k, end - k)) {
        if (!is_blank(d)) word += d;
      }
      k = end;
      first_word = false;
      double value = 0;
      if (!lines_.number(word, column + 1, value)) return;
      switch (c) {
        case 'G': {
          good = g_code(value, column);
          const double whole = std::round(value);
          move_word = move_word || whole == 0 || whole == 1;
          break;
        }
        case 'X':
        case 'Y':
        case 'Z': {
          std::optional<double>& at = axis[static_cast<std::size_t>(c - 'X')];
          if (at) {
            lines_.error(column, std::string("two ") + c + " words in one line");
            return;
          }
          at = value;
          axis_column = column;
          break;
        }
        case 'F':
          path_.feed = value;
          break;
        case 'S':
          path_.spindle = value;
          break;
        case 'T':
          path_.tool_number = value >= 0 && value < 1e6 ? static_cast<int>(value) : 1;
          break;
        case 'M':
          if (value == 2 || value == 30) finished_ = true;
          break;
        case 'N':
        case 'P':
        case 'Q':
        case 'H':
        case 'D':
          break;
        default:
          lines_.error(column, std::string("the word ") + c +
                                   " is not supported; expected three-axis straight moves");
          return;
      }
    }
    if (!good || dwell_) return;
    if (!axis[0] && !axis[1] && !axis[2]) return;
    if (!motion_) {
      lines_.error(axis_column, "a position without a motion: expected G0 or G1 before it");
      return;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      if (!axis[k]) continue;
      if (relative_ && !at_[k]) {
        lines_.error(axis_column, "a relative move (G91) from a position that is not known");
        return;
      }
      at_[k] = relative_ ? *at_[k] + *axis[k] : *axis[k];
    }
    // Until every axis has been told the position is the machine's own affair.
    if (!at_[0] || !at_[1] || !at_[2]) {
      if (*motion_ == Motion::kFeed) {
        lines_.error(axis_column, "a cutting move from a position that is not known");
      }
      return;
    }
    points_.add(Vec3(*at_[0], *at_[1], *at_[2]), *motion_);
  }

  PathLines lines_;
  ToolPath& path_;
  PointsRead& points_;
  std::optional<Motion> motion_;
  std::array<std::optional<double>, 3> at_;
  bool relative_ = false, finished_ = false, dwell_ = false;
};

}  // namespace

void read_gcode(TextSource& text, const std::string& file_name, ToolPath& head, PointsRead& points,
                Diagnostics& diagnostics) {
  GcodeReader(text, file_name, head, points, diagnostics).read();
}

}  // namespace diesink
