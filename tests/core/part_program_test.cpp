// Part programs: what good ones mean, what broken ones are told.
// SPDX-License-Identifier: Apache-2.0
#include "core/part_program/part_program.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <set>

#include "core/solids/kinds.h"
#include "tests/support/random_program.h"

namespace diesink {
namespace {

namespace fs = std::filesystem;

const fs::path kFixtures = fs::path(DIESINK_SOURCE_DIR) / "fixtures";

std::string file_text(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<fs::path> programs_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".part") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

// Every message as `LINE:COLUMN: error: text`.
std::vector<std::string> messages(const Diagnostics& diagnostics) {
  std::vector<std::string> all;
  for (const Diagnostic& d : diagnostics.all()) {
    all.push_back(std::to_string(d.where.line) + ':' + std::to_string(d.where.column) +
                  (d.severity == Severity::kError ? ": error: " : ": warning: ") + d.message);
  }
  return all;
}

std::vector<std::string> messages_of(std::string_view text) {
  Diagnostics diagnostics;
  const std::optional<PartProgram> program = parse_part_program(text, "x.part", diagnostics);
  EXPECT_EQ(program.has_value(), !diagnostics.has_errors());
  return messages(diagnostics);
}

PartProgram parsed(std::string_view text) {
  Diagnostics diagnostics;
  std::optional<PartProgram> program = parse_part_program(text, "folder/x.part", diagnostics);
  for (const Diagnostic& d : diagnostics.all()) {
    if (d.severity == Severity::kError) ADD_FAILURE() << to_text(d);
  }
  return program ? std::move(*program) : PartProgram{};
}

// A sphere of the given radius text.
PartProgram sphere_program(const std::string& radius) {
  return parsed("SOLID-DEF\nS1,SPHER\nP1,0,0,0\nRAD," + radius + "\nBOOLE-DEF\nS1\n");
}

const QuadricBody& quadric(const PartProgram& program, std::size_t solid = 0) {
  return std::get<QuadricBody>(program.solids.at(solid).body);
}

// ---- broken programs ----

TEST(BrokenPrograms, GiveTheMessagesTheyName) {
  const std::vector<fs::path> files = programs_in(kFixtures / "broken");
  EXPECT_GE(files.size(), 100u);
  for (const fs::path& path : files) {
    const std::string text = file_text(path);
    std::vector<std::string> expected;
    constexpr std::string_view kMark = "$$ expect ";
    for (std::size_t at = text.find(kMark); at != std::string::npos; at = text.find(kMark, at)) {
      at += kMark.size();
      expected.push_back(text.substr(at, text.find_first_of("\r\n", at) - at));
    }
    EXPECT_FALSE(expected.empty()) << path;
    EXPECT_EQ(messages_of(text), expected) << path.filename();
  }
}

// ---- numbers ----

TEST(Numbers, AreReadAsWritten) {
  const std::pair<std::string, double> numbers[] = {
      {"30", 30},
      {".8", 0.8},
      {"1.5E-3", 1.5e-3},
      {"+2.", 2},
      {"1.D0", 1},
      {"1d+2", 100},
      {" 7\t", 7},
      {"0.1e1", 1},
      {"00012.50", 12.5},
      {"0.00000001D8", 1},
      {"12345678901234567890e-12", 12345678.901234567890}};
  for (const auto& [text, value] : numbers) {
    EXPECT_EQ(quadric(sphere_program(text)).A, value) << text;
  }
}

TEST(Numbers, OfTheWrongFormAreErrors) {
  for (const std::string text :
       {"nan",   "-NAN",  "inf", "Infinity", "1e999", "1D400", "1e309", "0.0001e313",
        "0x1p3", "1e",    "1e+", ".",        "+",     "-",     "--1",   "1.2.3",
        "1 2",   "1e5.0", "e5",  "1_000",    "1,5",   "١",     "1f",    "1e99999999999999999999"}) {
    const std::vector<std::string> found =
        messages_of("SOLID-DEF\nS1,SPHER\nP1,0,0,0\nRAD," + text + "\nBOOLE-DEF\nS1\n");
    ASSERT_EQ(found.size(), 1u) << text;
    EXPECT_EQ(found[0].substr(0, 2), "4:") << text;
  }
  // Too small to be held is zero, which a coordinate may be.
  EXPECT_EQ(quadric(parsed("SOLID-DEF\nS1,SPHER\nP1,1e-400,-1E-99999999999,0.0000\nRAD,1\n"
                           "BOOLE-DEF\nS1\n"))
                .p,
            Vec3::Zero());
}

// ---- text ----

TEST(Text, MeansTheSameInAnySpelling) {
  const std::string plain = file_text(kFixtures / "parts" / "allprims.part");
  std::string lower, crlf, spaced = "\xEF\xBB\xBF";
  for (const char c : plain) {
    lower += static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    if (c == '\n') {
      crlf += "\r\n";
      spaced += " \t$$ note, with commas # and more\n\n   \n# another\n";
    } else if (c == ',') {
      crlf += c;
      spaced += "\t , ";
    } else {
      crlf += c;
      spaced += c;
    }
  }
  const PartProgram expected = parsed(plain);
  ASSERT_EQ(expected.solids.size(), 26u);
  for (const std::string& text : {lower, crlf, spaced}) {
    const PartProgram program = parsed(text);
    ASSERT_EQ(program.solids.size(), expected.solids.size());
    for (std::size_t k = 0; k < expected.solids.size(); ++k) {
      EXPECT_EQ(program.solids[k].id, expected.solids[k].id);
      EXPECT_EQ(program.solids[k].type, expected.solids[k].type);
      EXPECT_EQ(program.solids[k].option, expected.solids[k].option);
      const std::array<Vec3, 2> a = bounds_of(program.solids[k].body),
                                b = bounds_of(expected.solids[k].body);
      EXPECT_EQ(a[0], b[0]);
      EXPECT_EQ(a[1], b[1]);
    }
    EXPECT_EQ(program.boole.size(), expected.boole.size());
    EXPECT_EQ(program.machining.x_range, expected.machining.x_range);
  }
}

TEST(Text, SectionsStandInAnyOrder) {
  const std::string sections[] = {"SOLID-DEF\nS1,SPHER\nP1,1,2,3\nRAD,4\n",
                                  "BSURF-DEF\nPLANE,1.5\n", "BOOLE-DEF\nB\n+S1\n",
                                  "MACHI-DEF\nX-RNG,0,5\nY-RNG,1,5\nX-INT,.5\n"};
  int order[] = {0, 1, 2, 3};
  do {
    std::string text;
    for (const int k : order) text += sections[k];
    const PartProgram program = parsed(text);
    ASSERT_EQ(program.boole.size(), 2u);
    EXPECT_EQ(program.boole[1].surface, 1);
    EXPECT_EQ(program.boole[1].row, 1);
    EXPECT_EQ(std::get<PlaneBase>(program.base).point.z(), 1.5);
    EXPECT_EQ(program.machining.x_interval, 0.5);
    EXPECT_EQ(program.machining.y_interval, 0.05);
    EXPECT_FALSE(program.machining.y_interval_stated);
  } while (std::next_permutation(std::begin(order), std::end(order)));
}

TEST(Text, ADataKeywordMayNameASolid) {
  const PartProgram program = parsed(
      "SOLID-DEF\nA,ELLIP,2\nA,3\nB,2\nC,1\nP1,0,0,0\nP1,SPHER\nP1,1,1,1\nRAD,2\n"
      "BOOLE-DEF\nA+P1\n");
  ASSERT_EQ(program.solids.size(), 2u);
  EXPECT_EQ(program.solids[1].id, "P1");
}

TEST(Text, SolidsMayBeNamedLikeASectionMisspelt) {
  const PartProgram program = parsed(
      "SOLID-DEF\nMACHI,SPHER\nP1,0,0,0\nRAD,3\nDEFF,SPHER\nP1,0,0,9\nRAD,7\n"
      "BOOLE-DEF\nMACHI-DEFF\n");
  EXPECT_EQ(program.boole.size(), 2u);
}

TEST(Text, NameAndFile) {
  const PartProgram program = sphere_program("1");
  EXPECT_EQ(program.name, "x");
  EXPECT_EQ(program.file, "folder/x.part");
  EXPECT_EQ(program.solids[0].where.file, "folder/x.part");
  EXPECT_EQ(program.solids[0].where.line, 2u);
}

TEST(Text, CaretStandsUnderTheFault) {
  Diagnostics diagnostics;
  parse_part_program("SOLID-DEF\nS1,SPHER\n\tP1,0,\xC3\xA4,0\nRAD,1\nBOOLE-DEF\nS1\n", "x.part",
                     diagnostics);
  ASSERT_EQ(diagnostics.all().size(), 1u);
  EXPECT_EQ(to_text(diagnostics.all()[0]),
            "x.part:3:7: error: \"\\xc3\\xa4\" is not a number\n  \tP1,0,\xC3\xA4,0\n  \t     ^");
}

TEST(Text, CaretLineIsShownSafely) {
  Diagnostics diagnostics;
  diagnostics.error("m", {"x", 1, 4, -1}, "\x1B[2Jx");
  diagnostics.error("m", {"x", 1, 5000, -1}, std::string(9000, 'a'));
  EXPECT_EQ(to_text(diagnostics.all()[0]), "x:1:4: error: m\n  ?[2Jx\n     ^");
  const std::string far = to_text(diagnostics.all()[1]);
  EXPECT_LT(far.size(), 400u);
  EXPECT_EQ(far.back(), '^');
}

TEST(Text, OfTwoBytesALetterIsTold) {
  const std::vector<std::string> told = {
      "1:1: error: the text is in UTF-16; ASCII or UTF-8 is expected"};
  EXPECT_EQ(messages_of(std::string_view("\xFF\xFE"
                                         "B\0O\0",
                                         6)),
            told);
  EXPECT_EQ(messages_of(std::string_view("\xFE\xFF\0B\0O", 6)), told);
}

TEST(Limits, AreMessages) {
  const std::string head = "BOOLE-DEF\nS1\nSOLID-DEF\nS1,SPHER\nP1,0,0,0\nRAD,1\n";
  EXPECT_EQ(messages_of(std::string((16u << 20) + 1, ' ')),
            std::vector<std::string>{"1:1: error: the part program has more than 16 MiB"});
  EXPECT_EQ(messages_of(head + std::string((1u << 20) + 1, '#')),
            std::vector<std::string>{"7:1: error: the line is longer than the limit of 1 MiB"});
  std::string many;
  for (int k = 0; k <= 100'000; ++k) many += "x\n";
  EXPECT_EQ(messages_of(many),
            std::vector<std::string>{
                "100001:1: error: the part program has more than the limit of 100000 statements"});
  EXPECT_TRUE(messages_of(head + std::string((1u << 20) - 1, '#')).empty());
}

// ---- expression ----

std::string steps_text(const PartProgram& program) {
  std::string text;
  for (const BooleanStep& step : program.boole) {
    switch (step.kind) {
      case BooleanStep::Kind::kGroupOpen:
        text += '(';
        break;
      case BooleanStep::Kind::kGroupClose:
        text += ')';
        break;
      case BooleanStep::Kind::kTerm:
        text += (step.sign == Sign::kPlus ? '+' : '-') + std::to_string(step.surface) + '@' +
                std::to_string(step.row);
    }
  }
  return text;
}

PartProgram with_expression(const std::string& expression) {
  return parsed(
      "SOLID-DEF\nS1,SPHER\nP1,0,0,0\nRAD,1\nS2,SPHER\nP1,1,0,0\nRAD,1\n"
      "BSURF-DEF\nPLANE,0\nMACHI-DEF\nX-RNG,0,1\nY-RNG,0,1\nBOOLE-DEF\n" +
      expression + '\n');
}

TEST(Expression, BecomesSteps) {
  EXPECT_EQ(steps_text(with_expression("B+S2-S1")), "+0@0+2@1-1@2");
  EXPECT_EQ(steps_text(with_expression("+b + (s1 -\n s2)\n-S1\n")), "+0@0(+1@1-2@2)-1@3");
  EXPECT_EQ(steps_text(with_expression("((S1)+B)-S2")), "((+1@0)+0@1)-2@2");
  EXPECT_EQ(
      steps_text(with_expression(std::string(64, '(') + "S1" + std::string(64, ')') + "+S2+B")),
      std::string(64, '(') + "+1@0" + std::string(64, ')') + "+2@1+0@2");
}

TEST(Expression, WarnsOfWhatHasNoEffect) {
  const std::string text =
      "SOLID-DEF\nS1,SPHER\nP1,0,0,0\nRAD,1\nS2,SPHER\nP1,0,0,0\nRAD,1\n"
      "BSURF-DEF\nPLANE,0\nBOOLE-DEF\n";
  EXPECT_EQ(messages_of(text + "S1"),
            (std::vector<std::string>{
                "5:1: warning: S2 does not stand in the expression",
                "8:1: warning: the base surface does not stand in the expression"}));
  EXPECT_EQ(messages_of(text + "-S1+S2+B\nMACHI-DEF\nX-RNG,0,1\nY-RNG,0,1\n"),
            (std::vector<std::string>{
                "11:1: warning: the first term is subtracted from nothing and has no effect"}));
}

// ---- base and domain ----

TEST(Base, EveryKind) {
  const std::string tail = "BOOLE-DEF\nB\nMACHI-DEF\nX-RNG,0,1\nY-RNG,0,1\n";
  const PartProgram plane = parsed("BSURF-DEF\nplane\nNOR,0,3,-4\nP1,1,2,3\n" + tail);
  EXPECT_EQ(std::get<PlaneBase>(plane.base).point, Vec3(1, 2, 3));
  EXPECT_LT((std::get<PlaneBase>(plane.base).normal - Vec3(0, -0.6, 0.8)).norm(), 1e-15);

  const std::string points = "0,0,1\n2,0,1\n4,0,2\n0,3,1\n2,3,1\n4,3,2\n";
  for (const std::string header : {"3,2\n", "FERGU,3,2\n", "fergu , 3., +2\n"}) {
    const PartProgram program = parsed("BSURF-DEF\n" + header + points + tail);
    const FergusonBase& base = std::get<FergusonBase>(program.base);
    EXPECT_EQ(base.columns, 3);
    EXPECT_EQ(base.rows, 2);
    ASSERT_EQ(base.points.size(), 6u);
    EXPECT_EQ(base.points[5], Vec3(4, 3, 2));
    EXPECT_EQ(base.where.line, 2u);
  }

  const PartProgram scan = parsed(
      "BSURF-DEF\nMESH, Scans/Relief, old.STL \nROTX,90\nSCALE,25.4\nMOVE,1,2,3\nROTZ,-5\n"
      "NORMALS,smooth\nFILL,2.5\n" +
      tail);
  const MeshBase& mesh = std::get<MeshBase>(scan.base);
  EXPECT_EQ(mesh.path, "Scans/Relief, old.STL");
  ASSERT_EQ(mesh.placement.size(), 4u);
  EXPECT_EQ(mesh.placement[0].kind, MeshPlacement::Kind::kRotateX);
  EXPECT_EQ(mesh.placement[1].value[0], 25.4);
  EXPECT_EQ(mesh.placement[2].value, Vec3(1, 2, 3));
  EXPECT_TRUE(mesh.smooth_normals);
  EXPECT_EQ(mesh.fill_size, 2.5);

  EXPECT_TRUE(std::holds_alternative<std::monostate>(
      parsed("SOLID-DEF\nS1,SPHER\nP1,0,0,0\nRAD,1\nBSURF-DEF\nNONE\nBOOLE-DEF\nS1\n").base));
}

TEST(Domain, FollowsBaseOrSolids) {
  const PartProgram ferguson =
      parsed("BSURF-DEF\n2,2\n1,2,0\n11,3,0\n0,8,0\n12,7,0\nBOOLE-DEF\nB\n");
  EXPECT_EQ(ferguson.machining.x_range, (std::array<double, 2>{0, 12}));
  EXPECT_EQ(ferguson.machining.y_range, (std::array<double, 2>{2, 8}));
  EXPECT_EQ(ferguson.machining.x_interval, 0.12);
  EXPECT_EQ(ferguson.machining.y_interval, 0.12);

  // A plane has no extent; a solid outside the expression has no say.
  const std::string solids =
      "SOLID-DEF\nS1,SPHER\nP1,0,1,0\nRAD,2\nS2,4-PRIS,3\nP1,5,5,5\nP2,6,9,6\nS3,SPHER\nP1,99,99,"
      "0\n"
      "RAD,9\n";
  const PartProgram plane =
      parsed(solids + "BSURF-DEF\nPLANE,0\nBOOLE-DEF\nB+S1-S2\nMACHI-DEF\nX-INT,.5\n");
  EXPECT_EQ(plane.machining.x_range, (std::array<double, 2>{-2, 6}));
  EXPECT_EQ(plane.machining.y_range, (std::array<double, 2>{-1, 9}));
  EXPECT_EQ(plane.machining.x_interval, 0.5);
  EXPECT_EQ(plane.machining.y_interval, 0.1);

  // A scan is read elsewhere.
  const PartProgram scan = parsed("BSURF-DEF\nMESH,a.stl\nBOOLE-DEF\nB\n");
  EXPECT_EQ(scan.machining.x_range, (std::array<double, 2>{0, 0}));
}

TEST(Machining, EveryStatement) {
  const PartProgram program = parsed(
      "units,inch\nBSURF-DEF\nPLANE,0\nBOOLE-DEF\nB\nMACHI-DEF\nX-RNG,-1,2\nY-RNG,0,4\nX-INT,."
      "25\nY-INT,.5\n"
      "INTOL,0\nOUTTOL,.002\nCUTTER,10,2\nCUSP,.1\nFEDRAT,600\nSPINDL,12000\nCLEAR,-5\n");
  const Machining& m = program.machining;
  EXPECT_EQ(program.unit, LengthUnit::kInch);
  EXPECT_DOUBLE_EQ(m.tolerance, 0.01 / 25.4);
  EXPECT_EQ(m.x_range, (std::array<double, 2>{-1, 2}));
  EXPECT_EQ(m.y_range, (std::array<double, 2>{0, 4}));
  EXPECT_EQ(m.x_interval, 0.25);
  EXPECT_EQ(m.y_interval, 0.5);
  EXPECT_TRUE(m.y_interval_stated);
  EXPECT_EQ(m.intol, 0.0);
  EXPECT_EQ(m.outtol, 0.002);
  ASSERT_TRUE(m.cutter);
  EXPECT_EQ(m.cutter->diameter, 10);
  EXPECT_EQ(m.cutter->corner_radius, 2);
  EXPECT_EQ(m.cusp, 0.1);
  EXPECT_EQ(m.feed, 600);
  EXPECT_EQ(m.spindle, 12000);
  EXPECT_EQ(m.clearance, -5);
  const Machining plain = sphere_program("1").machining;
  EXPECT_EQ(plain.tolerance, 0.01);
  EXPECT_FALSE(plain.intol || plain.cutter || plain.cusp || plain.feed || plain.clearance);
}

// ---- every kind ----

TEST(GoodPrograms, AreAccepted) {
  for (const fs::path& path : programs_in(kFixtures / "parts")) {
    Diagnostics diagnostics;
    EXPECT_TRUE(parse_part_program(file_text(path), path.string(), diagnostics)) << path;
    for (const Diagnostic& d : diagnostics.all()) ADD_FAILURE() << to_text(d);
  }
}

TEST(GoodPrograms, RandomOnesAreAcceptedAndWalkEveryKind) {
  std::set<std::pair<std::string_view, int>> seen;
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    Diagnostics diagnostics;
    const std::optional<PartProgram> program =
        parse_part_program(test::random_part_program(seed), "random.part", diagnostics);
    for (const Diagnostic& d : diagnostics.all()) ADD_FAILURE() << seed << ' ' << to_text(d);
    ASSERT_TRUE(program);
    for (const Solid& solid : program->solids) seen.emplace(solid.type, solid.option);
  }
  std::size_t known = 0;
  for (const SolidKind* kind : solid_kinds()) known += kind->options.size();
  EXPECT_EQ(seen.size(), known);
}

// ---- the description of the language ----

TEST(Documentation, NamesEveryWordOfTheTable) {
  const std::string page = file_text(fs::path(DIESINK_SOURCE_DIR) / "docs" / "part-program.md");
  for (const std::vector<std::string_view>& words : {solid_type_words(), solid_field_words()}) {
    for (const std::string_view word : words) {
      // P2 and the like stand in ranges such as `P1`..`P4`.
      if (word.size() == 2 && word[0] == 'P') continue;
      EXPECT_NE(page.find('`' + std::string(word) + '`'), std::string::npos) << word;
    }
  }
}

TEST(Documentation, ExampleIsAProgram) {
  const std::string page = file_text(fs::path(DIESINK_SOURCE_DIR) / "docs" / "part-program.md");
  const std::size_t begin = page.find("```part\nSOLID-DEF") + 8;
  const PartProgram program = parsed(page.substr(begin, page.find("```", begin) - begin));
  EXPECT_EQ(program.solids.size(), 2u);
  EXPECT_EQ(program.boole.size(), 3u);
}

// ---- damaged programs ----

// Whatever the bytes: a program, or errors that stand inside the text.
void expect_sane(const std::string& text) {
  Diagnostics diagnostics;
  const std::optional<PartProgram> program = parse_part_program(text, "x.part", diagnostics);
  ASSERT_EQ(program.has_value(), !diagnostics.has_errors()) << text;
  ASSERT_LE(diagnostics.error_count(), 20u);
  const auto lines = 1 + std::count(text.begin(), text.end(), '\n');
  for (const Diagnostic& d : diagnostics.all()) {
    ASSERT_GE(d.where.line, 1u);
    ASSERT_LE(d.where.line, lines);
    ASSERT_GE(d.where.column, 1u);
    ASSERT_LE(d.where.column, d.source_line.size() + 1);
    ASSERT_FALSE(d.message.empty());
    for (const char c : d.message) ASSERT_TRUE(c >= 0x20 && c < 0x7F) << d.message;
  }
}

TEST(DamagedPrograms, CutAndChangedAtEveryByte) {
  test::Random random(20);
  // Blanks, separators, digits, letters of numbers and keywords, and bytes that no text has.
  constexpr char kBytes[] = "\n\r,+-().$#0 9eEDBPS\xFF\x80\t";  // and the zero at its end
  const auto any_byte = [&] {
    return kBytes[static_cast<std::size_t>(random.below(static_cast<int>(sizeof kBytes)))];
  };
  std::vector<std::string> texts = {file_text(kFixtures / "parts" / "fig6.part"),
                                    file_text(kFixtures / "parts" / "allprims.part")};
  for (std::uint64_t seed = 0; seed < 4; ++seed) texts.push_back(test::random_part_program(seed));
  for (const std::string& text : texts) {
    for (std::size_t at = 0; at < text.size(); ++at) {
      expect_sane(text.substr(0, at));
      std::string changed = text;
      switch (random.below(4)) {
        case 0:
          changed[at] = any_byte();
          break;
        case 1:
          changed.erase(at, 1);
          break;
        case 2:
          changed.insert(at, 1, any_byte());
          break;
        default:
          changed[at] =
              static_cast<char>(static_cast<unsigned char>(changed[at]) ^ (1u << random.below(8)));
      }
      expect_sane(changed);
      if (HasFatalFailure()) return;
    }
  }
}

TEST(DamagedPrograms, LinesMixedAndValuesExtreme) {
  test::Random random(21);
  constexpr const char* kValues[] = {"0",    "-0", "1e9", "-1e9", "1e-300", "1e300",
                                     "1e-9", "-1", "nan", "",     "B",      "1.0000001"};
  for (int round = 0; round < 1500; ++round) {
    std::vector<std::string> lines;
    std::string text = test::random_part_program(static_cast<std::uint64_t>(round % 40));
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t end = text.find('\n', at);
      lines.push_back(text.substr(at, end - at));
      at = end + 1;
    }
    const auto any_line = [&] {
      return static_cast<std::size_t>(random.below(static_cast<int>(lines.size())));
    };
    for (int k = 0; k < 3; ++k) {
      const std::size_t a = any_line(), b = any_line();
      switch (random.below(4)) {
        case 0:
          std::swap(lines[a], lines[b]);
          break;
        case 1:
          lines[a] = lines[b];
          break;
        case 2:
          lines.erase(lines.begin() + static_cast<std::ptrdiff_t>(a));
          break;
        default: {
          const std::size_t comma = lines[a].rfind(',');
          if (comma != std::string::npos)
            lines[a] = lines[a].substr(0, comma + 1) + kValues[random.below(12)];
        }
      }
    }
    std::string mixed;
    for (const std::string& line : lines) mixed += line + '\n';
    expect_sane(mixed);
    if (HasFatalFailure()) return;
  }
}

}  // namespace
}  // namespace diesink
