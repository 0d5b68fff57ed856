// APT CL-data of the usual flavours: words in either order, blanks anywhere, $ and $$, 3 or 6
// values. Arcs: CIRCLE/x,y,z,i,j,k,r before a GOTO (ISO 4343, Siemens NX, Creo), MOVARC with an
// angle (Autodesk), TLON,GOFWD/(CIRCLE/..),ON,(LINE/..) (CATIA).
// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "core/counted.h"
#include "core/nearest.h"
#include "core/number.h"
#include "formats/path_arc.h"
#include "formats/path_formats.h"
#include "formats/path_text.h"

namespace diesink {
namespace {

struct Word {
  std::string text;  // upper case, no blanks
  std::size_t column = 1;
};

// A circle that the next position lies on. The motion turns by the right hand about its axis (as
// written by Siemens NX, by the left); where an angle is stated, it tells which way.
struct Circle {
  Vec3 center = Vec3::Zero(), axis = Vec3::UnitZ();
  double radius = 0;
  std::optional<double> angle;  // radians
  Place place;
};

class AptReader {
 public:
  AptReader(TextSource& text, const std::string& file_name, ToolPath& path, PointsRead& points,
            Diagnostics& diagnostics)
      : lines_(text, file_name, diagnostics), path_(path), points_(points) {}

  void read() {
    while (!finished_ && lines_.next()) {
      std::string_view line = lines_.line();
      // Cards: columns 73 to 80 hold a sequence number.
      if (line.size() == 80 &&
          line.substr(72).find_first_not_of("0123456789 ") == std::string_view::npos) {
        line = line.substr(0, 72);
      }
      const std::string_view text = without_blanks(line);
      // Creo's notes, "$$-> CSYS / ..., $", go on like statements.
      if (note_ || (!continued_ && text.substr(0, 4) == "$$->")) {
        note_ = text.size() > 2 && text.back() == '$';
        continue;
      }
      if (!continued_ && is_remark(text)) {
        // What INSERT hands to the controller may be anything, also a move.
        if (upper_case(text.substr(0, 6)) == "INSERT") pass_over("INSERT", 1);
        continue;
      }
      // Creo names itself in the head of its files, "$$* Pro/CLfile Version ...".
      if (text.substr(0, 3) == "$$*" && upper_case(text).find("PRO/CLFILE") != std::string::npos) {
        several_ = true;
      }
      bool more = false;
      if (const std::size_t dollar = line.find('$'); dollar != std::string_view::npos) {
        const bool comment = line.substr(dollar, 2) == "$$";
        more = !comment;
        line = line.substr(0, dollar);
      }
      take_words(line);
      continued_ = more;
      if (!more) {
        statement();
        major_ = {};
        words_.clear();
        slash_ = false;
      }
    }
    if (continued_) statement();
    no_arc_waits("the end of the path");
    if (unknown_ > 0) {
      Place place = unknown_place_;
      lines_.warning(place.column,
                     counted(unknown_,
                             "statement|statements| without meaning for the path passed "
                             "over, the first '") +
                         unknown_word_ + "' in line " + std::to_string(place.line));
    }
  }

 private:
  static bool is_remark(std::string_view text) {
    const std::string head = upper_case(text.substr(0, 6));
    return head == "PARTNO" || head == "PPRINT" || head == "REMARK" || head == "TPRINT" ||
           head == "INSERT";
  }

  // MAJOR/word,word,...; blanks inside words mean nothing.
  void take_words(std::string_view line) {
    Word word;
    const auto close = [&](bool always) {
      if (!word.text.empty() || always) words_.push_back(word);
      word = {};
    };
    for (std::size_t k = 0; k < line.size(); ++k) {
      const char c = line[k];
      if (is_blank(c)) continue;
      if (c == '/' && !slash_) {
        slash_ = true;
        if (major_.text.empty()) major_ = word;
        word = {};
      } else if (c == ',') {
        if (!slash_ && major_.text.empty()) {
          major_ = word;
          slash_ = true;
          word = {};
        } else {
          close(true);
        }
      } else {
        if (word.text.empty()) word.column = k + 1;
        word.text += c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
      }
    }
    if (!slash_ && major_.text.empty()) {
      major_ = word;
    } else {
      close(false);
    }
  }

  bool numbers(std::size_t from, std::size_t count, double* values) {
    for (std::size_t k = 0; k < count; ++k) {
      const Word& word = words_[from + k];
      if (!lines_.number(word.text, word.column, values[k])) return false;
    }
    return true;
  }

  // The first of the words that is a number.
  std::optional<double> first_number() {
    for (const Word& word : words_) {
      if (!word.text.empty() &&
          (std::string_view("+-.0123456789").find(word.text[0]) != std::string_view::npos)) {
        double value = 0;
        if (lines_.number(word.text, word.column, value)) return value;
        return std::nullopt;
      }
    }
    return std::nullopt;
  }

  [[nodiscard]] bool has(std::string_view text) const {
    return std::any_of(words_.begin(), words_.end(), [&](const Word& w) { return w.text == text; });
  }

  void go_to(Motion motion) {
    if (words_.size() != 3 && words_.size() != 6) {
      lines_.error(major_.column, major_.text + " with " + std::to_string(words_.size()) +
                                      " values; expected x,y,z or x,y,z,i,j,k");
      return;
    }
    std::array<double, 6> v{0, 0, 0, 0, 0, 1};
    if (!numbers(0, words_.size(), v.data()) || !upright(3, &v[3])) return;
    move_to({v[0], v[1], v[2]}, motion);
    rapid_ = false;
  }

  // False after an error, where a tool axis is not (0, 0, 1). `from` is its first word.
  bool upright(std::size_t from, const double* axis) {
    // Digits of a post-processor; the tip stays where it is.
    constexpr double kTilt = 1e-6;
    if (std::fabs(axis[0]) <= kTilt && std::fabs(axis[1]) <= kTilt && axis[2] > 0) return true;
    lines_.error(words_[from].column, "a tool axis that is not 0,0,1; expected three-axis CL-data");
    return false;
  }

  void move_to(const Vec3& to, Motion motion) {
    if (!circle_ && goes_on_ && motion == Motion::kFeed) {
      // Creo gives more than one position of an arc: those on the circle, less than half a turn on.
      const Circle& c = *goes_on_;
      const Vec3 from = points_.last();
      const bool on = same_radius(radius_about(c.center, c.axis, to), c.radius, path_.unit) &&
                      to != from && turn_between(c.center, c.axis, from, to) < std::numbers::pi;
      if (on) circle_ = goes_on_;
    }
    goes_on_.reset();
    if (!circle_) {
      points_.add(to, motion);
      return;
    }
    // Where several positions are given the first may be where the arc begins.
    if (several_ && points_.count() > 0 && to == points_.last()) return;
    arc_to(to, *circle_, motion);
    if (several_) goes_on_ = circle_;
    circle_.reset();
  }

  void arc_to(const Vec3& to, const Circle& c, Motion motion) {
    if (points_.count() == 0) {
      lines_.error(c.place, "an arc needs a position before it");
      return;
    }
    const std::array<Vec3, 2> ends{points_.last(), to};
    for (const Vec3& p : ends) {
      const double radius = radius_about(c.center, c.axis, p);
      if (radius > 0 && same_radius(radius, c.radius, path_.unit)) continue;
      lines_.error(c.place, std::string("an arc that does not ") +
                                (&p == &ends[0] ? "begin" : "end") +
                                " on its circle: " + number_text(radius) +
                                " from the centre; expected the radius " + number_text(c.radius));
      return;
    }
    PathArc arc{c.center, c.axis, turn_between(c.center, c.axis, ends[0], to)};
    if (c.angle) {
      // Some posts give the plane's normal whichever way the motion turns.
      const double other = 2 * std::numbers::pi - arc.turn;
      constexpr double kDigits = 0.02;  // radians, of the angle as written
      if (std::fabs(arc.turn - *c.angle) > kDigits) {
        if (std::fabs(other - *c.angle) > kDigits) {
          lines_.error(c.place, "an arc whose ANGLE is not that between its ends");
          return;
        }
        arc.axis = -arc.axis;
        arc.turn = other;
      }
    }
    path_.arc_height = std::max(path_.arc_height, add_arc(points_, to, arc, motion, path_.unit));
  }

  // An arc must be followed by its end.
  void no_arc_waits(std::string_view instead) {
    if (!circle_) return;
    lines_.error(circle_->place,
                 "an arc without its end: expected GOTO behind it, found " + std::string(instead));
    circle_.reset();
  }

  // CIRCLE/x,y,z,i,j,k,r[,more] and MOVARC/x,y,z,i,j,k,r,ANGLE,a or
  // MOVARC/CENTER,..,AXIS,..,RADIUS,r.
  void circle() {
    std::array<double, 7> v{};
    std::size_t count = 0;
    Circle c;
    c.place = lines_.place(major_.column);
    for (std::size_t k = 0; k < words_.size(); ++k) {
      const std::string& word = words_[k].text;
      if (word == "CENTER" || word == "AXIS" || word == "RADIUS") continue;
      if (word == "ANGLE" && k + 1 < words_.size()) {
        double degrees = 0;
        if (!lines_.number(words_[k + 1].text, words_[k + 1].column, degrees)) return;
        c.angle = std::fabs(degrees) * std::numbers::pi / 180;
        ++k;
        continue;
      }
      if (word == "TIMES") {
        lines_.error(words_[k].column, "an arc of several turns (" + major_.text +
                                           " with TIMES) is not supported; expected one " +
                                           major_.text + " and GOTO a turn");
        return;
      }
      double value = 0;
      if (!lines_.number(word, words_[k].column, value)) return;
      if (count < v.size()) v[count] = value;
      ++count;  // NX goes on with tolerances and the tool
    }
    const Vec3 axis(v[3], v[4], v[5]);
    if (count < v.size() || !(axis.norm() > 0.5) || !(v[6] > 0)) {
      lines_.error(
          major_.column,
          major_.text + " that is no arc; expected x,y,z,i,j,k,r: centre, axis and radius");
      return;
    }
    c.center = Vec3(v[0], v[1], v[2]);
    c.axis = clockwise_ ? Vec3(-axis.normalized()) : axis.normalized();
    c.radius = v[6];
    circle_ = c;
  }

  // TLON,GOFWD/(CIRCLE/x,y,z,r),ON,[2,INTOF,](LINE/x,y,z,xe,ye,ze): in the plane of x and y, from
  // the last position in the direction of INDIRV to (xe, ye, ze).
  void tool_on() {
    std::array<double, 10> v{};
    std::size_t count = 0;
    bool good = true;
    for (std::size_t k = 0; k < words_.size() && good; ++k) {
      std::string text = words_[k].text;
      while (!text.empty() && text.back() == ')') text.pop_back();
      if (text == "ON" || text == "INTOF") continue;
      if (text == "2" && k > 0 && words_[k - 1].text == "ON") continue;
      if (const std::size_t slash = text.rfind('/'); slash != std::string::npos) {
        const std::string head = text.substr(0, slash);
        good = (count == 0 && (head == "GOFWD/(CIRCLE" || head == "GOFWD/CIRCLE")) ||
               (count == 4 && (head == "(LINE" || head == "LINE"));
        text.erase(0, slash + 1);
      }
      good = good && count < v.size();
      if (good && !lines_.number(text, words_[k].column, v[count++])) return;
    }
    if (!good || count != v.size() || !(v[3] > 0)) {
      lines_.error(major_.column,
                   "TLON in a form that is not supported; expected "
                   "TLON,GOFWD/(CIRCLE/x,y,z,r),ON,(LINE/x,y,z,x,y,z)");
      return;
    }
    if (!direction_ || points_.count() == 0) {
      lines_.error(major_.column, "an arc needs a position and INDIRV/i,j,k before it");
      return;
    }
    Circle c;
    c.place = lines_.place(major_.column);
    c.center = Vec3(v[0], v[1], v[2]);
    c.radius = v[3];
    const Vec3 out = points_.last() - c.center;
    const double side = out.x() * direction_->y() - out.y() * direction_->x();
    if (!(std::fabs(side) > 0.1 * out.norm() * direction_->norm())) {
      lines_.error(major_.column, "an arc whose INDIRV does not lead along its circle");
      return;
    }
    if (side < 0) c.axis = -c.axis;
    arc_to({v[7], v[8], v[9]}, c, rapid_ ? Motion::kRapid : Motion::kFeed);
    direction_.reset();
    rapid_ = false;
  }

  void vector_words(std::optional<Vec3>& out) {
    std::array<double, 3> v{};
    if (words_.size() != 3) {
      lines_.error(major_.column, major_.text + " needs i,j,k");
    } else if (numbers(0, 3, v.data())) {
      out = Vec3(v[0], v[1], v[2]);
    }
  }

  // NX states where the coordinates' frame lies; all of a path must be in one.
  void frame() {
    std::string text;
    for (const Word& word : words_) text += word.text + ",";
    if (points_.count() > 0 && !frame_.empty() && text != frame_) {
      lines_.error(major_.column, "the coordinate system (MSYS) changes within the path");
    }
    frame_ = text;
  }

  void statement() {
    const std::string& m = major_.text;
    if (m.empty() && words_.empty()) return;
    if (m != "GOTO") goes_on_.reset();
    if (m == "TOOLPATH" || m == "TLDATA" || m == "MSYS") clockwise_ = true;
    if (m == "FROM" || m == "GODLTA" || m == "TLON" || m == "GOHOME") no_arc_waits(m);
    if (m == "GOTO") {
      go_to(rapid_ ? Motion::kRapid : Motion::kFeed);
    } else if (m == "FROM") {
      go_to(Motion::kRapid);
      if (points_.count() > 0) from_ = points_.last();
    } else if (m == "GOHOME") {
      go_home();
    } else if (m == "GODLTA") {
      std::array<double, 3> v{0, 0, 0};
      const bool up = words_.size() == 1;  // along the tool's axis
      if ((!up && words_.size() != 3) || points_.count() == 0) {
        lines_.error(major_.column,
                     "GODLTA with " + std::to_string(words_.size()) +
                         " values; expected dx,dy,dz, or d along the axis, after a position");
      } else if (up ? numbers(0, 1, &v[2]) : numbers(0, 3, v.data())) {
        points_.add(points_.last() + Vec3(v[0], v[1], v[2]),
                    rapid_ ? Motion::kRapid : Motion::kFeed);
        rapid_ = false;
      }
    } else if (m == "RAPID") {
      rapid_ = true;
    } else if (m == "UNITS") {
      units();
    } else if (m == "CUTTER" || m == "TLDATA") {
      cutter();
    } else if (m == "INTOL" || m == "OUTTOL" || m == "TOLER") {
      if (const std::optional<double> v = first_number()) {
        if (m != "OUTTOL") path_.intol = *v;
        if (m != "INTOL") path_.outtol = *v;
      }
    } else if (m == "FEDRAT") {
      if (const std::optional<double> v = first_number()) path_.feed = *v;
      rapid_ = false;
    } else if (m == "SPINDL") {
      if (const std::optional<double> v = first_number()) path_.spindle = *v;
    } else if (m == "LOADTL" || m == "LOAD") {
      if (const std::optional<double> v = first_number(); v && *v >= 0 && *v < 1e6) {
        const int number = static_cast<int>(*v);
        if (points_.count() > 0 && loaded_ && number != path_.tool_number) {
          lines_.error(major_.column, "the tool changes within the path; expected one a file");
        }
        path_.tool_number = number;
        loaded_ = true;
      }
    } else if (m == "FINI") {
      finished_ = true;
    } else if (m == "CIRCLE" || m == "MOVARC") {
      no_arc_waits(m);
      circle();
    } else if (m == "TLON") {
      tool_on();
    } else if (m == "CUTCOM") {
      if (has("LEFT") || has("RIGHT")) {
        lines_.error(major_.column,
                     "compensation of the cutter by the controller (CUTCOM) is not supported");
      }
    } else if (m == "INDIRV") {
      vector_words(direction_);
    } else if (m == "MSYS") {
      frame();
    } else if (m == "TLAXIS") {
      std::array<double, 3> axis{};
      if (words_.size() != 3) {
        lines_.error(major_.column, "TLAXIS needs i,j,k");
      } else if (numbers(0, 3, axis.data())) {
        upright(0, axis.data());
      }
    } else if (m == "ARC" || m == "ARCSLP" || m == "GOFWD" || m == "GOLFT" || m == "GORGT" ||
               m == "GOBACK" || m == "CYCLE" || m == "COPY" || m == "TRACUT" || m == "ORIGIN" ||
               m == "TRANS" || m == "ROTATE" || m == "ROTHED" || m == "ROTABL" || m == "TLLFT" ||
               m == "TLRGT" || m == "PSIS") {
      if ((m == "CYCLE" && has("OFF")) ||
          (m == "ARCSLP" && words_.size() == 1 && (has("ON") || has("OFF")))) {
        return;  // arcs may climb, or no longer: their ends tell
      }
      lines_.error(major_.column,
                   m == "COPY"
                       ? "COPY is not supported: its copies are not in the file; expected "
                         "each copy's own GOTO and arcs, as a post-processor writes them out"
                       : m + " is not supported; expected GOTO and arcs (CIRCLE, MOVARC, "
                             "TLON,GOFWD)");
    } else if (m == "MULTAX" || m == "END-OF-PATH" || m == "TOOLPATH" || m == "PAINT" ||
               m == "COOLNT" || m == "MACHIN" || m == "STOP" || m == "OPSTOP" || m == "MODE" ||
               m == "CATPROCESS" || m == "TPNAME" || m == "LINTOL" || m == "DELAY" || m == "END" ||
               m == "PLUNGE" || m == "CLEARP" || m == "AUTOPS" || m == "TOOLNO" || m == "SEQNO") {
      // No motion.
    } else {
      if (!m.empty() && std::string_view("+-.0123456789").find(m[0]) != std::string_view::npos) {
        lines_.error(major_.column, "a statement that begins with a number; expected a word");
        return;
      }
      if (pass_over(m, major_.column)) {
        const std::vector<std::string_view> known{"GOTO",  "RAPID",  "UNITS",  "CUTTER", "FEDRAT",
                                                  "INTOL", "OUTTOL", "SPINDL", "GODLTA"};
        // A misspelt motion must not be dropped.
        if (const std::optional<std::size_t> near = nearest_word(m, known)) {
          lines_.error(major_.column, "unknown word '" + m.substr(0, 40) + "'; did you mean '" +
                                          std::string(known[*near]) + "'?");
        }
      }
    }
  }

  // Counts a statement that is not looked at; true for the first of a path.
  bool pass_over(std::string_view word, std::size_t column) {
    if (unknown_++ > 0) return false;
    unknown_place_ = lines_.place(column);
    unknown_word_ = word.substr(0, 40);
    return true;
  }

  void units() {
    LengthUnit unit = LengthUnit::kMillimetre;
    if (has("INCH") || has("INCHES") || has("IN")) {
      unit = LengthUnit::kInch;
    } else if (has("CM")) {
      unit = LengthUnit::kCentimetre;
    } else if (!has("MM")) {
      lines_.error(major_.column, "UNITS/ names no unit that is known; expected MM or INCHES");
      return;
    }
    if (points_.count() > 0 && unit != path_.unit) {
      lines_.error(major_.column, "the unit changes within the path; expected one a file");
      return;
    }
    path_.unit = unit;
  }

  // Back to where FROM began, or to a stated place.
  void go_home() {
    if (!words_.empty()) {
      go_to(Motion::kRapid);
    } else if (from_) {
      move_to(*from_, Motion::kRapid);
    } else {
      lines_.error(major_.column, "GOHOME without FROM before it: expected where home is");
    }
    rapid_ = false;
  }

  // Letters that do not stand where a number should: NAN is no kind of tool.
  static bool is_a_word(const std::string& text) {
    double value = 0;
    return !text.empty() && text[0] >= 'A' && text[0] <= 'Z' &&
           read_number(text.data(), text.data() + text.size(), value).state !=
               NumberState::kNotFinite;
  }

  void cutter() {
    // TLDATA/MILL,d,r,height,taper,tip and CUTTER/d,r,e,f,a,b,h.
    std::vector<double> v;
    for (const Word& word : words_) {
      if (v.empty() && is_a_word(word.text)) {
        if (word.text != "MILL" && major_.text == "TLDATA") {
          lines_.error(word.column,
                       "a tool of type " + word.text.substr(0, 40) + "; expected MILL");
          return;
        }
        continue;
      }
      double value = 0;
      if (!lines_.number(word.text, word.column, value)) return;
      v.push_back(value);
    }
    if (v.empty()) {
      lines_.error(major_.column, major_.text + " without a diameter");
      return;
    }
    Cutter cutter{v[0], v.size() > 1 ? v[1] : 0};
    if (!(cutter.diameter > 0) || !(cutter.corner_radius >= 0) ||
        cutter.corner_radius > cutter.diameter / 2 * (1 + 1e-9)) {
      lines_.error(words_.front().column,
                   "no cutter: expected a positive diameter and a corner radius up to half of it");
      return;
    }
    const bool tapered = major_.text == "CUTTER" && v.size() > 5 && (v[4] != 0 || v[5] != 0);
    if (tapered) {
      lines_.error(words_.front().column, "a cutter with a taper or a point; expected angles 0");
      return;
    }
    // e and f are where the corner's centre lies: out from the axis and up from the tip.
    if (major_.text == "CUTTER" && v.size() > 3 && (v[2] != 0 || v[3] != 0)) {
      const double out = cutter.diameter / 2 - cutter.corner_radius;
      const double digits = 1e-3 * cutter.diameter;
      if (std::fabs(v[2] - out) > digits || std::fabs(v[3] - cutter.corner_radius) > digits) {
        lines_.error(words_.front().column,
                     "a cutter whose corner does not end in its side and its end; expected e = d/2 "
                     "- r and f = r");
        return;
      }
    }
    if (v.size() == 1) {
      lines_.warning(words_.front().column,
                     "only a diameter: taken as a flat end; --cutter D,R states a corner radius");
    }
    if (points_.count() > 0 && path_.cutter &&
        (path_.cutter->diameter != cutter.diameter ||
         path_.cutter->corner_radius != cutter.corner_radius)) {
      lines_.error(major_.column, "the cutter changes within the path; expected one a file");
      return;
    }
    path_.cutter = cutter;
  }

  PathLines lines_;
  ToolPath& path_;
  PointsRead& points_;
  Word major_;
  std::vector<Word> words_;
  bool slash_ = false, continued_ = false, finished_ = false, rapid_ = false, loaded_ = false,
       note_ = false;
  std::optional<Circle> circle_, goes_on_;  // of the next position, and after it
  bool clockwise_ = false;                  // about the axis of CIRCLE: Siemens NX
  bool several_ = false;                    // an arc may have more positions than its end
  std::optional<Vec3> direction_;           // INDIRV
  std::optional<Vec3> from_;                // FROM
  std::string frame_;                       // MSYS
  std::size_t unknown_ = 0;
  Place unknown_place_;
  std::string unknown_word_;
};

}  // namespace

void read_apt(TextSource& text, const std::string& file_name, ToolPath& head, PointsRead& points,
              Diagnostics& diagnostics) {
  AptReader(text, file_name, head, points, diagnostics).read();
}

}  // namespace diesink
