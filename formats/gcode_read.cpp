// G-code of straight moves and arcs: words and modal state of RS274/NGC and of controllers like it,
// as far as a three-axis path needs them.
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/number.h"
#include "formats/path_arc.h"
#include "formats/path_formats.h"
#include "formats/path_text.h"

namespace diesink {
namespace {

enum class Move : std::uint8_t { kRapid, kFeed, kClockwise, kAnticlockwise };

// The words of one block that make a move.
struct Block {
  std::array<std::optional<double>, 3> axis, center;  // X Y Z, I J K
  std::optional<double> radius, turns;                // R, P
  std::size_t column = 1;                             // of the last of them
  bool machine = false;                               // G53: in the machine's own coordinates
  bool home = false;                                  // G28, G30
  bool motion = false;                                // G0 to G3 in this line

  [[nodiscard]] bool moves() const { return axis[0] || axis[1] || axis[2]; }
  [[nodiscard]] bool turns_about() const { return center[0] || center[1] || center[2] || radius; }
};

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

  bool g_code(double code, std::size_t column, Block& block) {
    const int tenths = static_cast<int>(std::lround(code * 10));
    switch (tenths) {
      case 0:
        return motion(Move::kRapid, column, block);
      case 10:
        return motion(Move::kFeed, column, block);
      case 20:
        return motion(Move::kClockwise, column, block);
      case 30:
        return motion(Move::kAnticlockwise, column, block);
      case 170:
      case 180:
      case 190:
        // The plane's axes in the order in which the third one follows by the right hand.
        normal_ = tenths == 170 ? 2 : tenths == 180 ? 1 : 0;
        return true;
      case 200:
        return unit(LengthUnit::kInch, column);
      case 210:
        return unit(LengthUnit::kMillimetre, column);
      case 280:
      case 300:
        block.home = true;
        return true;
      case 530:
        block.machine = true;
        return true;
      case 540:
      case 550:
      case 560:
      case 570:
      case 580:
      case 590:
        if (points_.count() > 0 && frame_ != tenths) {
          lines_.error(column, "the coordinate system (G54 to G59) changes within the path");
          return false;
        }
        frame_ = tenths;
        return true;
      case 900:
        relative_ = false;
        return true;
      case 910:
        relative_ = true;
        return true;
      case 901:
        absolute_centers_ = true;
        return true;
      case 911:
        absolute_centers_ = false;
        return true;
      case 40:
        dwell_ = true;
        return true;
      case 800:
        // `G0 G17 G40 G80 G90` at the head of a program: the motion stays.
        if (!block.motion) move_.reset();
        return true;
      case 400:
      case 430:  // the tool's length: positions are the tip's
      case 490:
      case 610:
      case 611:
      case 640:
      case 940:
      case 980:
      case 990:
      case 970:
        return true;
      default:
        lines_.error(
            column,
            "G" + std::to_string(code).substr(0, std::to_string(code).find_last_not_of("0.") + 1) +
                " is not supported; expected straight moves and arcs: G0 to G3, G17 to G21, G28, "
                "G40, G43, G49, G53 to G59, G61, G64, G80, G90, G91, G94");
        return false;
    }
  }

  bool motion(Move move, std::size_t column, Block& block) {
    if (block.motion && move_ != move) {
      lines_.error(column, "two motions (G0 to G3) in one line");
      return false;
    }
    block.motion = true;
    move_ = move;
    return true;
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
    Block block;
    dwell_ = false;
    bool good = true, first_word = true;
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
      double value = 0;
      if (!lines_.number(word, column + 1, value)) return;
      good = take(c, value, column, first_word, block);
      first_word = first_word && c == 'N';
    }
    if (good && !dwell_) act(block);
  }

  // One word; false after an error.
  bool take(char c, double value, std::size_t column, bool first, Block& block) {
    const auto once = [&](std::optional<double>& at) {
      if (at) {
        lines_.error(column, std::string("two ") + c + " words in one line");
        return false;
      }
      at = value;
      block.column = column;
      return true;
    };
    switch (c) {
      case 'G':
        return g_code(value, column, block);
      case 'X':
      case 'Y':
      case 'Z':
        return once(block.axis[static_cast<std::size_t>(c - 'X')]);
      case 'I':
      case 'J':
      case 'K':
        return once(block.center[static_cast<std::size_t>(c - 'I')]);
      case 'R':
        return once(block.radius);
      case 'P':
        block.turns = value;
        return true;
      case 'F':
        path_.feed = value;
        return true;
      case 'S':
        path_.spindle = value;
        return true;
      case 'T': {
        const int number = value >= 0 && value < 1e6 ? static_cast<int>(value) : 1;
        if (points_.count() > 0 && loaded_ && number != path_.tool_number) {
          lines_.error(column, "the tool changes within the path; expected one a file");
          return false;
        }
        path_.tool_number = number;
        loaded_ = true;
        return true;
      }
      case 'M':
        if (value == 2 || value == 30) finished_ = true;
        if (value == 97 || value == 98 || value == 99) {
          lines_.error(column, "subprograms (M98) are not supported");
          return false;
        }
        return true;
      case 'O':
        if (first && points_.count() == 0) return true;  // the program's number
        lines_.error(column, "subprograms (O) are not supported");
        return false;
      case 'A':
      case 'B':
      case 'C':
        if (value == 0 && !relative_) return true;  // upright
        break;
      case 'N':
      case 'Q':
      case 'H':
      case 'D':
        return true;
      default:
        break;
    }
    lines_.error(column, std::string("the word ") + c +
                             " is not supported; expected three-axis straight moves and arcs");
    return false;
  }

  void act(const Block& block) {
    if (block.home || block.machine) {
      away(block);
      return;
    }
    const bool arc = move_ && (*move_ == Move::kClockwise || *move_ == Move::kAnticlockwise);
    if (!block.moves() && !(arc && block.turns_about())) return;
    if (!move_) {
      lines_.error(block.column, "a position without a motion: expected G0 to G3 before it");
      return;
    }
    if (!arc && block.turns_about()) {
      lines_.error(block.column, "I, J, K and R need G2 or G3");
      return;
    }
    const std::array<std::optional<double>, 3> before = at_;
    for (std::size_t k = 0; k < 3; ++k) {
      if (!block.axis[k]) continue;
      if (relative_ && !at_[k]) {
        lines_.error(block.column, "a relative move (G91) from a position that is not known");
        return;
      }
      at_[k] = relative_ ? *at_[k] + *block.axis[k] : *block.axis[k];
    }
    // Until every axis has been told the position is the machine's own affair.
    const bool known = before[0] && before[1] && before[2];
    if (!at_[0] || !at_[1] || !at_[2] || (arc && !known)) {
      if (*move_ != Move::kRapid) {
        lines_.error(block.column, "a cutting move from a position that is not known");
      }
      return;
    }
    const Vec3 to(*at_[0], *at_[1], *at_[2]);
    if (!arc) {
      points_.add(to, *move_ == Move::kRapid ? Motion::kRapid : Motion::kFeed);
    } else if (points_.count() == 0) {
      lines_.error(block.column, "an arc from a position that is not known");
    } else {
      arc_to(block, points_.last(), to);
    }
  }

  // G28, G30 and G53 lead to places of the machine, which the path does not know; from there on the
  // axes named are unknown, so that a cutting move from them is an error.
  void away(const Block& block) {
    if (block.machine && move_ && *move_ != Move::kRapid) {
      lines_.error(block.column, "a cutting move in the machine's coordinates (G53)");
      return;
    }
    if (block.home && !relative_ && block.moves()) {
      lines_.error(block.column,
                   "G28 by way of another position is not supported; expected G91 G28 Z0");
      return;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      if (block.axis[k] || (block.home && !block.moves())) at_[k].reset();
      if (block.home && relative_ && block.axis[k] && *block.axis[k] != 0) {
        lines_.error(block.column,
                     "G28 by way of another position is not supported; expected G91 G28 Z0");
      }
    }
  }

  void arc_to(const Block& block, const Vec3& from, const Vec3& to) {
    // a, b and the normal follow each other by the right hand.
    const auto n = static_cast<std::size_t>(normal_);
    const std::size_t a = (n + 1) % 3, b = (n + 2) % 3;
    const bool left = *move_ == Move::kAnticlockwise;
    PathArc arc;
    arc.axis = Vec3::Zero();
    arc.axis[normal_] = left ? 1 : -1;
    arc.center = from;
    if (block.radius) {
      if (block.center[a] || block.center[b]) {
        lines_.error(block.column, "an arc with a radius and a centre; expected one of them");
        return;
      }
      const double da = to[static_cast<int>(a)] - from[static_cast<int>(a)];
      const double db = to[static_cast<int>(b)] - from[static_cast<int>(b)];
      const double chord = std::sqrt(da * da + db * db), r = *block.radius;
      if (!(chord > 0) || r == 0) {
        lines_.error(block.column, "an arc by its radius that ends where it begins");
        return;
      }
      if (chord / 2 > std::fabs(r) && !same_radius(chord / 2, std::fabs(r), path_.unit)) {
        lines_.error(block.column, "an arc whose ends lie " + number_text(chord) +
                                       " apart, more than its diameter");
        return;
      }
      // To the left of the chord where it turns left by less than a half turn.
      const double high = std::sqrt(std::max(0.0, (r - chord / 2) * (r + chord / 2)));
      const double side = ((r > 0) == left ? high : -high) / chord;
      arc.center[static_cast<int>(a)] += da / 2 - side * db;
      arc.center[static_cast<int>(b)] += db / 2 + side * da;
    } else {
      for (const std::size_t k : {a, b}) {
        if (absolute_centers_ && !block.center[k]) {
          lines_.error(block.column, "an arc without both its centre's words (G90.1)");
          return;
        }
        const double offset = block.center[k].value_or(0);
        arc.center[static_cast<int>(k)] =
            absolute_centers_ ? offset : from[static_cast<int>(k)] + offset;
      }
      if (block.center[n]) {
        lines_.error(block.column, "an arc whose centre lies out of its plane (G17, G18, G19)");
        return;
      }
    }
    const double r0 = radius_about(arc.center, arc.axis, from);
    const double r1 = radius_about(arc.center, arc.axis, to);
    if (!(r0 > 0) || !(r1 > 0) || !same_radius(r0, r1, path_.unit)) {
      lines_.error(block.column, "an arc that begins " + number_text(r0) + " and ends " +
                                     number_text(r1) + " from its centre");
      return;
    }
    double more = 0;
    if (block.turns) {
      more = *block.turns - 1;
      if (!(more >= 0 && more < 1e4) || more != std::round(more)) {
        lines_.error(block.column, "P of an arc must be a whole number of turns");
        return;
      }
    }
    arc.turn = turn_between(arc.center, arc.axis, from, to) + 2 * std::numbers::pi * more;
    path_.arc_height =
        std::max(path_.arc_height, add_arc(points_, to, arc, Motion::kFeed, path_.unit));
  }

  PathLines lines_;
  ToolPath& path_;
  PointsRead& points_;
  std::optional<Move> move_;
  std::array<std::optional<double>, 3> at_;
  int normal_ = 2;   // of the arcs' plane: 2 is G17
  int frame_ = 540;  // tenths of G54
  bool relative_ = false, absolute_centers_ = false;
  bool finished_ = false, dwell_ = false, loaded_ = false;
};

}  // namespace

void read_gcode(TextSource& text, const std::string& file_name, ToolPath& head, PointsRead& points,
                Diagnostics& diagnostics) {
  GcodeReader(text, file_name, head, points, diagnostics).read();
}

}  // namespace diesink
