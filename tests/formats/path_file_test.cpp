// Tool path files: what is written reads back, other programs' dialects are read, wrong ones are
// told.
// SPDX-License-Identifier: Apache-2.0
#include "formats/path_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <locale>
#include <numbers>
#include <span>
#include <vector>

#include "tests/support/random_program.h"

namespace diesink {
namespace {

ToolPath sample(LengthUnit unit = LengthUnit::kMillimetre) {
  ToolPath path;
  path.name =
      "die (no 1) $ of a rather long name that goes on and on beyond the seventy-second column";
  path.unit = unit;
  path.cutter = Cutter{6, 3};
  path.intol = 0.02;
  path.outtol = 0.01;
  path.feed = 800;
  path.spindle = 12000;
  path.clearance = 30;
  path.points = {{{1, 2, 30}, Motion::kRapid},
                 {{1, 2, -0.5}, Motion::kFeed},
                 {{-1234.56789, 2, 1e-7}, Motion::kFeed},
                 {{7, 8.25, 3}, Motion::kFeed},
                 {{7, 8.25, 30}, Motion::kRapid},
                 {{0, 0, 30}, Motion::kRapid},
                 {{0, 0, 1}, Motion::kFeed},
                 {{0, 0, 30}, Motion::kRapid}};
  return path;
}

std::string text_of(const ToolPath& path, PathFormat format,
                    AptFlavour flavour = AptFlavour::kApt) {
  MemoryFiles files;
  ByteSink* sink = files.file("").value();
  PathWriteOptions options;
  options.program_comment = "diesink 0.1.0";
  options.flavour = flavour;
  EXPECT_TRUE(write_path(path, format, options, *sink));
  const std::vector<FileBytes> out = files.take();
  return {reinterpret_cast<const char*>(out[0].bytes.data()), out[0].bytes.size()};
}

std::optional<ToolPath> read(const std::string& text, PathFormat format,
                             std::string* messages = nullptr) {
  Diagnostics diagnostics;
  std::optional<ToolPath> path = read_path(text, "path.txt", format, diagnostics);
  if (messages != nullptr) {
    messages->clear();
    for (const Diagnostic& d : diagnostics.all()) {
      *messages += std::to_string(d.where.line) + ":" + std::to_string(d.where.column) + " " +
                   d.message + "\n";
    }
  }
  EXPECT_EQ(path.has_value(), !diagnostics.has_errors());
  return path;
}

void expect_same(const ToolPath& a, const ToolPath& b, double within) {
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t k = 0; k < a.points.size(); ++k) {
    EXPECT_LE((a.points[k].tip - b.points[k].tip).cwiseAbs().maxCoeff(), within) << k;
    EXPECT_EQ(a.points[k].motion, b.points[k].motion) << k;
  }
  EXPECT_EQ(a.unit, b.unit);
  EXPECT_EQ(a.feed, b.feed);
  EXPECT_EQ(a.spindle, b.spindle);
  ASSERT_TRUE(b.cutter);
  EXPECT_EQ(a.cutter->diameter, b.cutter->diameter);
  EXPECT_EQ(a.cutter->corner_radius, b.cutter->corner_radius);
  EXPECT_NEAR(a.intol, b.intol, 1e-9);
  EXPECT_NEAR(a.outtol, b.outtol, 1e-9);
}

TEST(PathFile, EveryFormatReadsBack) {
  for (const LengthUnit unit : {LengthUnit::kMillimetre, LengthUnit::kInch}) {
    const ToolPath path = sample(unit);
    const double rounding = 0.5 * std::pow(10, -path_decimals(path)) * (1 + 1e-6);
    for (const AptFlavour flavour :
         {AptFlavour::kApt, AptFlavour::kNx, AptFlavour::kCatia, AptFlavour::kCreo}) {
      const std::string text = text_of(path, PathFormat::kApt, flavour);
      const auto back = read(text, PathFormat::kApt);
      ASSERT_TRUE(back);
      expect_same(path, *back, rounding);
      EXPECT_EQ(path_format_of_content(text, "x"), PathFormat::kApt);
    }
    const std::string ngc = text_of(path, PathFormat::kGcode);
    const auto from_ngc = read(ngc, PathFormat::kGcode);
    ASSERT_TRUE(from_ngc);
    expect_same(path, *from_ngc, rounding);
    EXPECT_EQ(path_format_of_content(ngc, "x"), PathFormat::kGcode);
    const std::string csv = text_of(path, PathFormat::kCsv);
    const auto from_csv = read(csv, PathFormat::kCsv);
    ASSERT_TRUE(from_csv);
    expect_same(path, *from_csv, 0);
    EXPECT_EQ(path_format_of_content(csv, "x"), PathFormat::kCsv);
  }
}

TEST(PathFile, RandomPathsReadBack) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    test::Random random(seed);
    ToolPath path = sample();
    path.intol = path.outtol = std::pow(10, random.uniform(-4, -1));
    path.points.clear();
    for (int k = 0; k < 200; ++k) {
      const double scale = std::pow(10, random.uniform(1, 4));
      const Vec3 tip{random.uniform(-scale, scale), random.uniform(-scale, scale),
                     random.uniform(-scale, scale)};
      path.points.push_back({tip, k == 0 || random.chance(0.2) ? Motion::kRapid : Motion::kFeed});
    }
    for (const PathFormat format : {PathFormat::kApt, PathFormat::kGcode}) {
      const auto back = read(text_of(path, format), format);
      ASSERT_TRUE(back);
      expect_same(path, *back, std::fmin(path.intol, path.outtol) / 1000);
    }
  }
}

TEST(PathFile, AptKeepsToItsCard) {
  for (const AptFlavour flavour :
       {AptFlavour::kApt, AptFlavour::kNx, AptFlavour::kCatia, AptFlavour::kCreo}) {
    const std::string text = text_of(sample(), PathFormat::kApt, flavour);
    std::size_t begin = 0;
    while (begin < text.size()) {
      const std::size_t end = text.find('\n', begin);
      EXPECT_LE(end - begin, 72u) << text.substr(begin, end - begin);
      begin = end + 1;
    }
    EXPECT_NE(text.find("RAPID\nGOTO/1.,2.,30.\n"), std::string::npos) << text;
    EXPECT_EQ(text.find("e-"), std::string::npos);
    EXPECT_EQ(text.substr(text.size() - 16), "SPINDL/OFF\nFINI\n");
  }
  EXPECT_NE(text_of(sample(), PathFormat::kApt).find("\nFEDRAT/800.,MMPM\n"), std::string::npos);
  EXPECT_NE(text_of(sample(), PathFormat::kApt, AptFlavour::kNx).find("\nFEDRAT/MMPM,800.\n"),
            std::string::npos);
  EXPECT_NE(
      text_of(sample(), PathFormat::kApt, AptFlavour::kCreo).find("\nSPINDL/RPM,12000.,CLW\n"),
      std::string::npos);
  EXPECT_NE(text_of(sample(LengthUnit::kInch), PathFormat::kApt).find("\nUNITS/INCHES\n"),
            std::string::npos);
}

TEST(PathFile, GcodeHead) {
  const std::string text = text_of(sample(), PathFormat::kGcode);
  EXPECT_NE(
      text.find(
          "\nG17 G21 G40 G49 G54 G80 G90 G94\nG64 P0.001 Q0\nT1 M6\nS12000 M3\nF800\nG0 Z30\n"),
      std::string::npos)
      << text;
  EXPECT_EQ(text.substr(text.size() - 6), "M5\nM2\n");
}

TEST(PathFile, AnEmptyPathIsNoFile) {
  for (const PathFormat format : {PathFormat::kApt, PathFormat::kGcode, PathFormat::kCsv}) {
    MemoryFiles files;
    ToolPath path = sample();
    path.points.resize(1);
    EXPECT_FALSE(write_path(path, format, {}, *files.file("").value()));
  }
}

TEST(PathFile, NumbersThatNoFileHoldsAreRefused) {
  const std::vector<std::function<void(ToolPath&)>> wrongs{
      [](ToolPath& path) { path.points[1].tip.z() = 1e16; },
      [](ToolPath& path) { path.points[0].tip.x() = -1e300; },
      [](ToolPath& path) { path.points[1].tip.y() = std::nan(""); },
      [](ToolPath& path) { path.spindle = 1e20; },
      [](ToolPath& path) { path.feed = 1e-9; },  // F0 stops the machine
      [](ToolPath& path) { path.outtol = 1e300; },
      [](ToolPath& path) {
        path.cutter = Cutter{1e300, 0};
      }};
  for (const PathFormat format : {PathFormat::kApt, PathFormat::kGcode, PathFormat::kCsv}) {
    for (const auto& spoil : wrongs) {
      MemoryFiles files;
      ToolPath path = sample();
      spoil(path);
      const Status done = write_path(path, format, {}, *files.file("").value());
      ASSERT_FALSE(done);
      EXPECT_EQ(done.error().code, ErrorCode::kInput);
    }
  }
}

TEST(AptRead, DialectsOfOthers) {
  // Siemens NX, Creo, CATIA, cards with sequence numbers, continued and blank-ridden statements.
  const auto nx = read(
      "TOOL PATH/FINISH,TOOL,BALL6\nTLDATA/MILL,6.0000,3.0000,75.0000,0.0000,0.0000\n"
      "MSYS/0.0,0.0,0.0,1.0,0.0,0.0,0.0,1.0,0.0\nPAINT/PATH\nRAPID\nGOTO/1.0,2.0,3.0,0.0,0.0,1.0\n"
      "FEDRAT/MMPM,250.0000\nGOTO/4.0,5.0,6.0\nEND-OF-PATH\n",
      PathFormat::kApt);
  ASSERT_TRUE(nx);
  EXPECT_EQ(nx->points.size(), 2u);
  EXPECT_EQ(nx->points[0].motion, Motion::kRapid);
  EXPECT_EQ(nx->points[1].motion, Motion::kFeed);
  EXPECT_EQ(nx->cutter->corner_radius, 3);
  EXPECT_EQ(nx->feed, 250);
  const auto creo = read(
      "$$* Pro/CLfile\nPARTNO / OP010\nUNITS / INCHES\nLOADTL / 1\nCUTTER / 0.250000, 0.125000\n"
      "RAPID\nGOTO / 1.0000000000, 2.0000000000, $\n 3.0000000000\ngoto / 1, 2, +1.5E0 $$ "
      "down\nFINI\n"
      "GOTO / 9,9,9\n",
      PathFormat::kApt);
  ASSERT_TRUE(creo);
  EXPECT_EQ(creo->unit, LengthUnit::kInch);
  ASSERT_EQ(creo->points.size(), 2u);
  EXPECT_EQ(creo->points[0].tip, Vec3(1, 2, 3));
  EXPECT_EQ(creo->points[1].tip, Vec3(1, 2, 1.5));
  const auto relative = read("FROM/0,0,10\r\nGODLTA/1,0,-10\r\n", PathFormat::kApt);
  ASSERT_TRUE(relative);
  EXPECT_EQ(relative->points[1].tip, Vec3(1, 0, 0));
  const auto down = read("FROM/1,2,10\nGODLTA/-4\n", PathFormat::kApt);
  ASSERT_TRUE(down);
  EXPECT_EQ(down->points[1].tip, Vec3(1, 2, 6));
  std::string card = "GOTO/1.,2.,3.";
  card.resize(72, ' ');
  const auto cards = read(card + "00000010\n" + card + "00000020\n", PathFormat::kApt);
  ASSERT_TRUE(cards);
  EXPECT_EQ(cards->points.size(), 2u);
}

// The length of the cutting moves, and the largest distance of their points and middles from the
// circle about `center` in the plane square to axis n.
struct Round {
  double length = 0, off = 0;
};
Round round_of(const ToolPath& path, const Vec3& center, double radius, int n) {
  Round out;
  const auto off = [&](Vec3 p) {
    p -= center;
    p[n] = 0;
    return std::fabs(p.norm() - radius);
  };
  for (std::size_t k = 1; k < path.points.size(); ++k) {
    const Vec3 &a = path.points[k - 1].tip, &b = path.points[k].tip;
    if (path.points[k].motion != Motion::kFeed) continue;
    out.length += (b - a).norm();
    out.off = std::max({out.off, off(a), off(b), off((a + b) / 2)});
  }
  return out;
}

TEST(GcodeRead, ArcsBecomeChordsWithinTheHeightToldOfThem) {
  struct Arc {
    const char* text;
    Vec3 center;
    double radius, degrees, rise;
    int normal;
  };
  const Arc cases[] = {
      {"G17 G0 X10 Y0 Z5\nG3 X0 Y10 I-10 J0\n", {0, 0, 0}, 10, 90, 0, 2},
      {"G17 G0 X10 Y0 Z5\nG2 X0 Y10 I-10 J0\n", {0, 0, 0}, 10, 270, 0, 2},
      {"G17 G0 X10 Y0 Z5\nG3 X0 Y10 R10\n", {0, 0, 0}, 10, 90, 0, 2},
      {"G17 G0 X10 Y0 Z5\nG2 X0 Y10 R-10\n", {0, 0, 0}, 10, 270, 0, 2},
      {"G17 G0 X10 Y0 Z5\nG2 X0 Y10 R10\n", {10, 10, 0}, 10, 90, 0, 2},
      {"G17 G0 X10 Y0 Z5\nG3 X0 Y10 R-10\n", {10, 10, 0}, 10, 270, 0, 2},
      {"G17 G0 X10 Y0 Z5\nG3 I-10\n", {0, 0, 0}, 10, 360, 0, 2},
      {"G0 G17 G40 G49 G80 G90\nX10 Y0 Z5\nG3 I-10\n", {0, 0, 0}, 10, 360, 0, 2},
      {"G17 G0 X10 Y0 Z5\nG3 I-10 Z2 P3\n", {0, 0, 0}, 10, 1080, -3, 2},
      {"G17 G0 X10 Y0 Z5\nG90.1 G3 X0 Y10 I0 J0 Z7\n", {0, 0, 0}, 10, 90, 2, 2},
      {"G18 G0 X0 Y1 Z10\nG3 X10 Z0 I0 K-10\n", {0, 0, 0}, 10, 90, 0, 1},
      {"G18 G0 X0 Y1 Z10\nG2 X-10 Z0 R10\n", {0, 0, 0}, 10, 90, 0, 1},
      {"G19 G0 X1 Y10 Z0\nG3 Y0 Z10 J-10\n", {0, 0, 0}, 10, 90, 0, 0},
      {"G90 G0 X10 Y0 Z5\nG91 N7 g3 x-10 y10 i-10 (left)\n", {0, 0, 0}, 10, 90, 0, 2},
      {"O7\n%\nG20\nG0 X.5 Y0 Z1\nG3 X0 Y.5 R.5\n", {0, 0, 0}, 0.5, 90, 0, 2},
      {"G0 X10 Y0 Z5\nG3 X0 Y10.005 I-10 J0\n", {0, 0, 0}, 10, 90, 0, 2}};
  for (const Arc& arc : cases) {
    const std::string text = arc.text;
    std::string messages;
    const auto path = read(text, PathFormat::kGcode, &messages);
    ASSERT_TRUE(path) << text << messages;
    const Round found = round_of(*path, arc.center, arc.radius, arc.normal);
    const double flat = arc.radius * arc.degrees / 180 * std::numbers::pi;
    // Chords are shorter than the arc by a 24th of the squared step.
    EXPECT_NEAR(found.length, std::hypot(flat, arc.rise), 6e-3 * arc.radius / 10) << text;
    EXPECT_LE(found.off, path->arc_height * (1 + 1e-9)) << text;
    EXPECT_GT(path->arc_height, 0) << text;
    EXPECT_LE(path->arc_height, 0.006) << text;
  }
}

TEST(AptRead, ArcsTurnAsTheSystemsWriteThem) {
  // A quarter or three of them from (10, 0) to (0, 10) about the origin.
  struct Arc {
    const char* text;
    double degrees;
  };
  const Arc cases[] = {
      {"GOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,10\nGOTO/0,10,0\n", 90},
      {"GOTO/10,0,0\nCIRCLE/0,0,0,0,0,-1,10\nGOTO/0,10,0,0,0,1\n", 270},
      {"TOOL PATH/A,TOOL,B\nGOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,10,.06,.5,6,0\nGOTO/0,10,0\n", 270},
      {"GOTO/10,0,0\nMOVARC/0,0,0,0,0,1,10,ANGLE,90\nGOTO/0,10,0\n", 90},
      {"GOTO/10,0,0\nMOVARC/0,0,0,0,0,1,10,ANGLE,270\nGOTO/0,10,0\n", 270},
      {"GOTO/10,0,0\nMOVARC/CENTER,0,0,0,AXIS,0,0,-1,RADIUS,10\nGOTO/0,10,0\n", 270},
      {"GOTO/10,0,0\nINDIRV/0,1,0\nTLON,GOFWD/(CIRCLE/0,0,0,10),ON,(LINE/0,0,0,0,10,0)\n", 90},
      {"GOTO/10,0,0\nINDIRV/0,-1,0\nTLON,GOFWD/ (CIRCLE/ 0,0,0,$\n 10),ON,2,INTOF,$\n"
       " (LINE/0,0,0,0,10,0)\n",
       270},
      {"$$* Pro/CLfile  Version 3.0\nGOTO / 10, 0, 0\nCIRCLE / 0, 0, 0, $\n 0, 0, -1, 10\n"
       "GOTO / 0, -10, 0\nGOTO / -10, 0, 0\nGOTO / 0, 10, 0\n",
       270}};
  for (const Arc& arc : cases) {
    std::string messages;
    const auto path = read(arc.text, PathFormat::kApt, &messages);
    ASSERT_TRUE(path) << arc.text << messages;
    const Round found = round_of(*path, Vec3::Zero(), 10, 2);
    EXPECT_NEAR(found.length, arc.degrees / 18 * std::numbers::pi, 6e-3) << arc.text;
    EXPECT_LE(found.off, path->arc_height * (1 + 1e-9)) << arc.text;
    EXPECT_EQ(path->points.back().tip, Vec3(0, 10, 0)) << arc.text;
  }
  // Elsewhere a circle ends at the next position, and what follows is straight.
  const auto slot =
      read("GOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,10\nGOTO/-10,0,0\nGOTO/10,0,0\n", PathFormat::kApt);
  ASSERT_TRUE(slot);
  EXPECT_NEAR(round_of(*slot, Vec3::Zero(), 10, 2).length, 10 * std::numbers::pi + 20, 6e-3);
}

TEST(PathRead, WrongOnesAreToldWithTheirPlace) {
  struct Wrong {
    PathFormat format;
    const char* text;
    const char* message;
  };
  const Wrong cases[] = {
      {PathFormat::kApt, "GOTO/1,2,3\nGOTO/1,x,3\n", "2:8 'X' is not a number"},
      {PathFormat::kApt, "GOTO/1,2\n", "1:1 GOTO with 2 values; expected x,y,z or x,y,z,i,j,k"},
      {PathFormat::kApt, "GOTO/1,2,nan\n", "1:10 'NAN' is not a number"},
      {PathFormat::kApt, "GOTO/1,2,3,1,0,0\n", "1:12 a tool axis that is not 0,0,1"},
      {PathFormat::kApt, "GOTOO/1,2,3\n", "1:1 unknown word 'GOTOO'; did you mean 'GOTO'?"},
      {PathFormat::kApt, "CIRCLE/1,2,3,0,0,1\n", "1:1 CIRCLE that is no arc"},
      {PathFormat::kApt, "CIRCLE/0,0,0,0,0,1,5\nGOTO/5,0,0\n", "1:1 an arc needs a position"},
      {PathFormat::kApt, "GOTO/5,0,0\nCIRCLE/0,0,0,0,0,1,5\n", "2:1 an arc without its end"},
      {PathFormat::kApt, "GOTO/5,0,0\nCIRCLE/0,0,0,0,0,1,5\nGOTO/0,6,0\n",
       "2:1 an arc that does not end on its circle: 6 from the centre"},
      {PathFormat::kApt, "GOTO/5,0,0\nMOVARC/0,0,0,0,0,1,5,ANGLE,120\nGOTO/0,5,0\n",
       "2:1 an arc whose ANGLE is not that between its ends"},
      {PathFormat::kApt, "GOTO/5,0,0\nCIRCLE/0,0,0,0,0,1,5,TIMES,2\nGOTO/5,0,0\n",
       "2:22 an arc of several turns (CIRCLE with TIMES) is not supported; expected one CIRCLE"},
      {PathFormat::kApt, "INDEX/1\nGOTO/5,0,0\nINDEX/1,NOMORE\nCOPY/1,TRANSL,10,0,0,3\n",
       "4:1 COPY is not supported: its copies"},
      {PathFormat::kApt, "GOTO/5,0,0\nGODLTA/1,2\n", "2:1 GODLTA with 2 values"},
      {PathFormat::kApt, "GOTO/5,0,0\nTLON,GOFWD/(CIRCLE/0,0,0,5),ON,(LINE/0,0,0,0,5,0)\n",
       "2:1 an arc needs a position and INDIRV"},
      {PathFormat::kApt, "GOTO/5,0,0\nTLON,GOFWD/(PLANE/0,0,1,5)\n", "2:1 TLON in a form"},
      {PathFormat::kApt, "TLAXIS/0.1,0,0.99\n", "1:8 a tool axis that is not 0,0,1"},
      {PathFormat::kApt, "CUTTER/6,3\nGOTO/1,2,3\nGOTO/2,2,3\nCUTTER/4,2\n",
       "4:1 the cutter changes within the path"},
      {PathFormat::kApt, "MSYS/0,0,0\nGOTO/1,2,3\nMSYS/0,0,1\n",
       "3:1 the coordinate system (MSYS) changes"},
      {PathFormat::kApt, "GOTO/1,2,3\n4,5,6\n", "2:1 a statement that begins with a number"},
      {PathFormat::kApt, "CUTCOM/LEFT\n", "1:1 compensation of the cutter"},
      {PathFormat::kApt, "TRACUT/MATRIX\n", "1:1 TRACUT is not supported"},
      {PathFormat::kApt, "UNITS/FURLONG\n", "1:1 UNITS/ names no unit"},
      {PathFormat::kApt, "GOTO/1,2,3\nUNITS/INCHES\nGOTO/2,2,3\n", "2:1 the unit changes"},
      {PathFormat::kApt, "CUTTER/6,1,0,3,0,0,40\n", "1:8 a cutter whose corner does not end"},
      {PathFormat::kApt, "GOTO/1,2,3\nGOHOME\n", "2:1 GOHOME without FROM"},
      {PathFormat::kApt, "ARCSLP/0.5\n", "1:1 ARCSLP is not supported"},
      {PathFormat::kApt, "CUTTER/-6,3\n", "no cutter"},
      {PathFormat::kApt, "CUTTER/nan,1\n", "1:8 'NAN' is not a number"},
      {PathFormat::kApt, "", "the file holds no tool path"},
      {PathFormat::kGcode, "G0 X1 Y2 Z3\nG2 X3 Y4 I1 J0\n", "2:13 an arc that begins 1 and ends"},
      {PathFormat::kGcode, "G0 X1 Y2 Z3\nG2 X9 Y2 R3\n", "2:10 an arc whose ends lie 8 apart"},
      {PathFormat::kGcode, "G0 X1 Y2 Z3\nG2 X1 Y2 R3\n",
       "2:10 an arc by its radius that ends where"},
      {PathFormat::kGcode, "G0 X1 Y2 Z3\nG1 X3 Y4 I1\n", "2:10 I, J, K and R need G2 or G3"},
      {PathFormat::kGcode, "G0 X1 Y2\nG2 X3 Y2 I1\n", "2:10 a cutting move from a position"},
      {PathFormat::kGcode, "G0 X1 Y2 Z3\nG91 G28 Z0\nG1 X2\n",
       "3:4 a cutting move from a position"},
      {PathFormat::kGcode, "G0 X1 Y2 Z3\nG28 X0\n", "2:5 G28 by way of another position"},
      {PathFormat::kGcode, "G0 X1 Y2 Z3\nT1 M6\nT2 M6\n", "3:1 the tool changes"},
      {PathFormat::kGcode, "G0 X1 Y2 Z3\nG55\n", "2:1 the coordinate system"},
      {PathFormat::kGcode, "G0 X1 Y2 Z3\nM98 P10\n", "2:1 subprograms"},
      {PathFormat::kGcode, "G81 X1\n", "1:1 G81 is not supported"},
      {PathFormat::kGcode, "G1 X1\n", "a cutting move from a position that is not known"},
      {PathFormat::kGcode, "G0 X1 X2\n", "1:7 two X words"},
      {PathFormat::kGcode, "G0 X1 Y2 Z3\nG1 G0 X2\n", "2:4 two motions"},
      {PathFormat::kGcode, "X1 Y2 Z3\n", "without a motion"},
      {PathFormat::kGcode, "G0 X#1\n", "1:5 '' is not a number"},
      {PathFormat::kGcode, "G0 X1e5\n", "word E"},
      {PathFormat::kGcode, "G0 A1\n", "the word A is not supported"},
      {PathFormat::kGcode, "(open\n", "1:1 a comment without its ')'"},
      {PathFormat::kCsv, "x,y,z\n1,2,3\n1,,3\n", "3:3 '' is not a number"},
      {PathFormat::kCsv, "x,y,z\n1,2\n", "2:1 2 fields; expected 3"},
      {PathFormat::kCsv, "x,y,z,motion\n1,2,3,fly\n", "2:7 'FLY' is no motion"},
      {PathFormat::kCsv, "1,2\n", "expected x,y,z"},
      {PathFormat::kCsv, "# unit cm\nx,y,z\n1,2,3\n1,2,4\n", "1:1 'cm' is no unit"},
      {PathFormat::kCsv, "x,y,z\n1,2,1e12\n", "is too large"}};
  for (const Wrong& wrong : cases) {
    std::string messages;
    EXPECT_FALSE(read(wrong.text, wrong.format, &messages)) << wrong.text;
    EXPECT_NE(messages.find(wrong.message), std::string::npos) << wrong.text << messages;
  }
}

TEST(PathRead, WrongWordsInTheHeadOfACsvAreTold) {
  for (const char* head : {"cutter -4,2", "cutter 4,3", "cutter 4", "cutter 1e300,1",
                           "cutter nan,1", "intol -1", "outtol 1e300", "feed", "spindle fast"}) {
    std::string messages;
    const std::string text = "# " + std::string(head) + "\nx,y,z\n1,2,3\n1,2,4\n";
    const std::optional<ToolPath> path = read(text, PathFormat::kCsv, &messages);
    ASSERT_TRUE(path) << text;
    EXPECT_FALSE(path->cutter);
    EXPECT_EQ(std::fmax(path->intol, path->outtol), 0);
    EXPECT_EQ(messages.rfind("1:1 states no ", 0), 0U) << text << messages;
  }
  std::string messages;
  EXPECT_TRUE(
      read("# made by hand\n# cutter 6 , 1\nx,y,z\n1,2,3\n1,2,4\n", PathFormat::kCsv, &messages)
          ->cutter);
  EXPECT_EQ(messages, "");
}

TEST(PathRead, AptGoesHomeAndTellsWhatItPassesOver) {
  std::string messages;
  const auto path = read(
      "UNITS/MM\nCUTTER/6,1,2,1,0,0,40\nMULTAX/OFF\nPPRINT HELLO\nINSERT G28 Z0\nFROM/0,0,50\n"
      "RAPID\nGOTO/5,0,3\nARCSLP/ON\nCIRCLE/0,0,0,0,0,1,5\nGOTO/0,5,4\nARCSLP/OFF\nGOHOME\nFINI\n",
      PathFormat::kApt, &messages);
  ASSERT_TRUE(path) << messages;
  ASSERT_GT(path->points.size(), 3u);
  EXPECT_EQ(path->points.back().tip, Vec3(0, 0, 50));
  EXPECT_EQ(path->points.back().motion, Motion::kRapid);
  EXPECT_EQ(path->points[path->points.size() - 2].tip, Vec3(0, 5, 4));
  EXPECT_NE(messages.find("'INSERT' in line 5"), std::string::npos) << messages;
}

TEST(PathRead, AnyDamageEndsInAPathOrErrors) {
  for (const PathFormat format : {PathFormat::kApt, PathFormat::kGcode, PathFormat::kCsv}) {
    const std::string good = text_of(sample(), format);
    test::Random random(1);
    for (std::size_t cut = 0; cut < good.size(); ++cut) {
      std::string bad = good;
      bad[cut] = static_cast<char>(random.below(256));
      for (const std::string& text : {good.substr(0, cut), bad}) {
        const std::optional<ToolPath> path = read(text, format);
        if (!path) continue;
        for (const ClPoint& point : path->points) EXPECT_TRUE(point.tip.allFinite()) << text;
      }
    }
  }
}

}  // namespace
}  // namespace diesink
