// CC-data as CSV and JSON, and plan points from a CSV.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "formats/csv_cc_data.h"
#include "formats/csv_points.h"
#include "tests/support/load_part.h"

namespace diesink {
namespace {

template <class Write>
std::string text_of_sink(const Write& write) {
  MemoryFiles files;
  const Result<ByteSink*> sink = files.file("");
  EXPECT_TRUE(write(**sink));
  const std::vector<FileBytes> written = files.take();
  return {reinterpret_cast<const char*>(written.at(0).bytes.data()), written[0].bytes.size()};
}

std::vector<std::vector<std::string>> table_of(const std::string& text) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    rows.emplace_back();
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) rows.back().push_back(field);
    if (line.back() == ',') rows.back().emplace_back();
  }
  return rows;
}

// Two spheres without a base: points with and without a surface.
CompoundSurface spheres() {
  return test::surface_of(
      "SOLID-DEF\nS1,SPHER,1\nP1,0.1,0,0\nRAD,5\nS2,SPHER,1\nP1,9,0,0\nRAD,5\n"
      "BOOLE-DEF\nS1+S2\nMACHI-DEF\nX-RNG,-6,15\nY-RNG,-6,6\nX-INT,0.7\nY-INT,0.7\n");
}

TEST(CcCsv, ReadsBackToTheBit) {
  const CompoundSurface surface = spheres();
  const Result<GridArray> grid = evaluate_grid(surface, 1);
  const std::string text =
      text_of_sink([&](ByteSink& sink) { return write_cc_csv(surface, *grid, sink); });
  const auto rows = table_of(text);
  EXPECT_EQ(text.substr(0, text.find('\n')), "x,y,z,nx,ny,nz,surface,row,face");
  ASSERT_EQ(rows.size(), grid->size() + 1);
  std::size_t holes = 0;
  for (std::size_t k = 0; k < grid->size(); ++k) {
    const std::vector<std::string>& r = rows[k + 1];
    ASSERT_EQ(r.size(), 9u);
    EXPECT_EQ(std::stod(r[0]), grid->x()[k % grid->columns()]);
    EXPECT_EQ(std::stod(r[1]), grid->y()[k / grid->columns()]);
    const std::optional<CcDatum> d = grid->at(surface, k);
    if (!d) {
      ++holes;
      for (std::size_t f = 2; f < 9; ++f) EXPECT_EQ(r[f], "");
      continue;
    }
    EXPECT_EQ(std::stod(r[2]), d->z);
    EXPECT_EQ(std::stod(r[3]), d->n.x());
    EXPECT_EQ(std::stod(r[4]), d->n.y());
    EXPECT_EQ(std::stod(r[5]), d->n.z());
    EXPECT_EQ(r[6], std::to_string(d->surface));
    EXPECT_EQ(r[7], std::to_string(d->row));
    EXPECT_EQ(r[8], std::to_string(d->face));
  }
  EXPECT_GT(holes, 10u);
  EXPECT_LT(holes, grid->size());
}

TEST(CcJson, SaysTheSameAsTheCsv) {
  const CompoundSurface surface = spheres();
  const Result<GridArray> grid = evaluate_grid(surface, 1);
  const nlohmann::json json = nlohmann::json::parse(
      text_of_sink([&](ByteSink& sink) { return write_cc_json(surface, *grid, sink); }));
  EXPECT_EQ(json["unit"], "mm");
  EXPECT_EQ(json["names"], (std::vector<std::string>{"B", "S1", "S2"}));
  EXPECT_EQ(json["x"].size(), grid->columns());
  EXPECT_EQ(json["y"].size(), grid->rows());
  ASSERT_EQ(json["points"].size(), grid->size());
  for (std::size_t k = 0; k < grid->size(); ++k) {
    const nlohmann::json& p = json["points"][k];
    const std::optional<CcDatum> d = grid->at(surface, k);
    EXPECT_EQ(p["x"].get<double>(), grid->x()[k % grid->columns()]);
    EXPECT_EQ(p["z"].is_null(), !d);
    EXPECT_EQ(p["face"].is_null(), !d);
    if (d) {
      EXPECT_EQ(p["z"].get<double>(), d->z);
      EXPECT_EQ(p["surface"].get<int>(), d->surface);
    }
  }
}

TEST(CcPoints, AreWrittenInTheirOrder) {
  const CompoundSurface surface = spheres();
  const std::vector<CcPoint> points = {{1, 2, surface.at(1, 2)}, {-6, -6, surface.at(-6, -6)}};
  const auto rows =
      table_of(text_of_sink([&](ByteSink& sink) { return write_cc_csv(points, sink); }));
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(std::stod(rows[1][2]), points[0].datum->z);
  EXPECT_EQ(rows[2], (std::vector<std::string>{"-6", "-6", "", "", "", "", "", "", ""}));
  const nlohmann::json json = nlohmann::json::parse(
      text_of_sink([&](ByteSink& sink) { return write_cc_json(surface, points, sink); }));
  EXPECT_EQ(json["points"].size(), 2u);
  EXPECT_TRUE(json["points"][1]["nz"].is_null());
}

TEST(EdgePairs, HaveBothSides) {
  const CompoundSurface surface = spheres();
  const Result<GridArray> grid = evaluate_grid(surface, 1);
  const std::vector<EdgePair> edges = find_edges(surface, *grid, 1);
  ASSERT_GT(edges.size(), 20u);
  const auto rows =
      table_of(text_of_sink([&](ByteSink& sink) { return write_edges_csv(edges, sink); }));
  ASSERT_EQ(rows.size(), edges.size() + 1);
  EXPECT_EQ(rows[0].size(), 19u);
  EXPECT_EQ(rows[0][0], "kind");
  EXPECT_EQ(rows[0][10], "x2");
  for (std::size_t k = 0; k < edges.size(); ++k) {
    ASSERT_EQ(rows[k + 1].size(), 19u);
    EXPECT_EQ(rows[k + 1][0], name_of(edges[k].kind));
    EXPECT_EQ(std::stod(rows[k + 1][1]), edges[k].first.x);
    EXPECT_EQ(std::stod(rows[k + 1][10]), edges[k].second.x);
    EXPECT_EQ(rows[k + 1][12].empty(), !edges[k].second.datum);
  }
  const nlohmann::json json = nlohmann::json::parse(
      text_of_sink([&](ByteSink& sink) { return write_edges_json(surface, edges, sink); }));
  ASSERT_EQ(json["edges"].size(), edges.size());
  EXPECT_EQ(json["edges"][0]["kind"], name_of(edges[0].kind));
  EXPECT_EQ(json["edges"][0]["second"]["y"].get<double>(), edges[0].second.y);
}

std::string errors_of(const std::string& text) {
  Diagnostics diagnostics;
  read_csv_points(text, "p.csv", diagnostics);
  std::string all;
  for (const Diagnostic& d : diagnostics.all()) {
    all += std::to_string(d.where.line) + ':' + std::to_string(d.where.column) + ' ';
  }
  return all;
}

std::vector<Vec2> points_of(const std::string& text) {
  Diagnostics diagnostics;
  std::vector<Vec2> points = read_csv_points(text, "p.csv", diagnostics);
  EXPECT_FALSE(diagnostics.has_errors());
  return points;
}

TEST(CsvPoints, TakesTheFormsOfTheContract) {
  const std::vector<Vec2> want = {Vec2(1, 2), Vec2(-0.5, 1500)};
  EXPECT_EQ(points_of("1,2\n-.5,1.5e3\n"), want);
  EXPECT_EQ(points_of("\xEF\xBB\xBFx,y\r\n 1 ,\t+2\r\n\r\n# note\r\n-.5,1.5e3 # more"), want);
  EXPECT_EQ(points_of("x,y,z,nx,ny,nz,surface,row,face\n1,2,,,,,,,\n-0.5,1500,3,0,0,1,0,0,0\n"),
            want);
  EXPECT_EQ(points_of("name,Y,X\na,2,1\nb,1500,-.5\n"), want);
  EXPECT_TRUE(points_of("").empty());
  EXPECT_TRUE(points_of("x,y\n").empty());
}

TEST(CsvPoints, SaysWhatIsWrongAndWhere) {
  EXPECT_EQ(errors_of("1,2\n3\n"), "2:1 ");
  EXPECT_EQ(errors_of("1,2,3\n"), "1:5 ");
  EXPECT_EQ(errors_of("1,zwei\n  x3,4\n"), "1:3 2:3 ");
  EXPECT_EQ(errors_of("x,y\n1,2\n1,2,3\n"), "3:5 ");
  EXPECT_EQ(errors_of("nan,1\n1,inf\n1,2e9\n1,1e999\n,1\n"), "1:1 2:3 3:3 4:3 5:1 ");
  EXPECT_EQ(errors_of("a,b\n"), "1:1 ");
  std::string many;
  for (int k = 0; k < 100; ++k) many += "bad\n";
  Diagnostics diagnostics;
  read_csv_points(many, "p.csv", diagnostics);
  EXPECT_EQ(diagnostics.error_count(), 20u);
  EXPECT_EQ(errors_of(std::string((1 << 20) + 1, '1')), "1:1 ");
}

}  // namespace
}  // namespace diesink
