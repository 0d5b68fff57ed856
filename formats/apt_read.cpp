// APT CL-data of the usual flavours: words in either order, blanks anywhere, $ and $$, 3 or 6
// values. SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/nearest.h"
#include "formats/path_formats.h"
#include "formats/path_text.h"

namespace diesink {
namespace {

struct Word {
  std::string text;  // upper case, no blanks
  std::size_t column = 1;
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
      if (const std::string_view text = without_blanks(line); !continued_ && is_remark(text))
        continue;
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
    if (unknown_ > 0) {
      Place place = unknown_place_;
      lines_.warning(place.column,
                     std::to_string(unknown_) +
                         " statements without meaning for the path passed over, the first '" +
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
    if (!numbers(0, words_.size(), v.data())) return;
    if (std::fabs(v[3]) > 1e-6 || std::fabs(v[4]) > 1e-6 || !(v[5] > 0)) {
      lines_.error(words_[3].column, "a tool axis that is not 0,0,1; expected three-axis CL-data");
      return;
    }
    points_.add({v[0], v[1], v[2]}, motion);
    rapid_ = false;
  }

  void statement() {
    const std::string& m = major_.text;
    if (m.empty() && words_.empty()) return;
    if (m == "GOTO") {
      go_to(rapid_ ? Motion::kRapid : Motion::kFeed);
    } else if (m == "FROM") {
      go_to(Motion::kRapid);
    } else if (m == "GODLTA") {
      std::array<double, 3> v{0, 0, 0};
      if (words_.size() != 3 || points_.count() == 0) {
        lines_.error(major_.column, "GODLTA/ needs dx,dy,dz and a position before it");
      } else if (numbers(0, 3, v.data())) {
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
        path_.tool_number = static_cast<int>(*v);
      }
    } else if (m == "FINI") {
      finished_ = true;
    } else if (m == "CIRCLE" || m == "ARC" || m == "MOVARC" || m == "GOFWD" || m == "GOLFT" ||
               m == "GORGT" || m == "GOBACK" || m == "CYCLE" || m == "GOHOME" || m == "COPY" ||
               m == "TRACUT") {
      if (m == "CYCLE" && has("OFF")) return;
      lines_.error(major_.column, m + " is not supported; expected straight moves (GOTO) only");
    } else if (m == "MULTAX" || m == "END-OF-PATH" || m == "TOOLPATH" || m == "MSYS" ||
               m == "PAINT" || m == "COOLNT" || m == "MACHIN" || m == "CUTCOM" || m == "STOP" ||
               m == "OPSTOP" || m == "MODE" || m == "CATPROCESS" || m == "TPNAME" ||
               m == "LINTOL" || m == "DELAY" || m == "END" || m == "PLUNGE" || m == "CLEARP" ||
               m == "TLAXIS" || m == "SEQNO") {
      // No motion.
    } else {
      if (unknown_++ == 0) {
        unknown_place_ = lines_.place(major_.column);
        unknown_word_ = m.substr(0, 40);
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

  void units() {
    if (has("MM")) {
      path_.unit = LengthUnit::kMillimetre;
    } else if (has("INCH") || has("INCHES") || has("IN")) {
      path_.unit = LengthUnit::kInch;
    } else if (has("CM")) {
      path_.unit = LengthUnit::kCentimetre;
    } else {
      lines_.error(major_.column, "UNITS/ names no unit that is known; expected MM or INCHES");
    }
  }

  void cutter() {
    // TLDATA/MILL,d,r,height,taper,tip and CUTTER/d,r,e,f,a,b,h.
    std::vector<double> v;
    for (const Word& word : words_) {
      if (v.empty() && !word.text.empty() && word.text[0] >= 'A' && word.text[0] <= 'Z') {
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
    path_.cutter = cutter;
  }

  PathLines lines_;
  ToolPath& path_;
  PointsRead& points_;
  Word major_;
  std::vector<Word> words_;
  bool slash_ = false, continued_ = false, finished_ = false, rapid_ = false;
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
