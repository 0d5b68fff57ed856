// Pictures: what is seen where, by geometry that is known without drawing it.
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "picture/annotate.h"
#include "picture/camera.h"
#include "picture/canvas.h"
#include "picture/mesh_film.h"
#include "picture/plan_film.h"
#include "picture/preview.h"
#include "picture/sharp_edges.h"
#include "picture/stroke_font.h"
#include "tests/support/load_part.h"

namespace diesink {
namespace {

// One picture unit a pixel, x right, y up, the origin at the bottom left.
Camera pixel_camera(double height) {
  Camera camera;
  camera.middle = Vec2(0, height);
  return camera;
}

TriangleMesh mesh_of(std::vector<Vec3> positions,
                     std::vector<std::array<std::uint32_t, 3>> triangles) {
  TriangleMesh mesh;
  mesh.positions = std::move(positions);
  mesh.triangles = std::move(triangles);
  return mesh;
}

Film film_of(const TriangleMesh& mesh, const Camera& camera, std::size_t w, std::size_t h,
             int threads = 1) {
  const Palette palette = palette_of(mesh);
  Paint paint;
  paint.palette = &palette;
  Film film(w, h);
  film_mesh(mesh, camera, paint, threads, film);
  return film;
}

double covered(const Film& film) {
  double sum = 0;
  for (const FilmPixel& each : film.pixels) sum += static_cast<double>(each.cover);
  return sum;
}

TEST(Camera, ViewsAreRightHandedFramesThatFillTheFrame) {
  const std::array<Vec3, 2> box{Vec3(1, 2, 3), Vec3(11, 8, 5)};
  const PixelBox frame{10, 20, 210, 120};
  for (const View view : {View::kPlan, View::kIso, View::kFront, View::kRight}) {
    const Camera camera = make_camera(view, box, frame);
    Mat3 axes;
    axes << camera.right, camera.up, camera.toward;
    EXPECT_NEAR((axes.transpose() * axes - Mat3::Identity()).norm(), 0, 1e-15);
    EXPECT_NEAR(axes(0, 0) * (axes(1, 1) * axes(2, 2) - axes(1, 2) * axes(2, 1)) -
                    axes(0, 1) * (axes(1, 0) * axes(2, 2) - axes(1, 2) * axes(2, 0)) +
                    axes(0, 2) * (axes(1, 0) * axes(2, 1) - axes(1, 1) * axes(2, 0)),
                1, 1e-15);
    double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
    for (int k = 0; k < 8; ++k) {
      const Vec3 p = camera.project(Vec3(box[k & 1].x(), box[k >> 1 & 1].y(), box[k >> 2].z()));
      left = std::min(left, p.x()), right = std::max(right, p.x());
      top = std::min(top, p.y()), bottom = std::max(bottom, p.y());
    }
    EXPECT_GE(left, 10 - 1e-9);
    EXPECT_LE(right, 210 + 1e-9);
    EXPECT_GE(top, 20 - 1e-9);
    EXPECT_LE(bottom, 120 + 1e-9);
    EXPECT_NEAR(std::min(200 - (right - left), 100 - (bottom - top)), 0, 1e-9)
        << "fills it one way";
  }
}

TEST(MeshFilm, CoverIsTheAreaOfTheTriangles) {
  const TriangleMesh mesh = mesh_of(
      {{3.2, 4.1, 0}, {90.7, 11.3, 5}, {40.4, 77.9, 2}, {95.5, 93.1, 1}}, {{0, 1, 2}, {1, 3, 2}});
  const auto area = [&](std::size_t t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Vec3 p = mesh.positions[b] - mesh.positions[a], q = mesh.positions[c] - mesh.positions[a];
    return std::abs(p.x() * q.y() - p.y() * q.x()) / 2;
  };
  // The two share a side: nothing is counted twice there, and no gap is left.
  EXPECT_NEAR(covered(film_of(mesh, pixel_camera(100), 100, 100)), area(0) + area(1), 4);
}

TEST(MeshFilm, TheNearerTriangleIsSeenWhicheverComesFirst) {
  for (const bool near_first : {false, true}) {
    TriangleMesh mesh =
        mesh_of({{0, 0, 1}, {40, 0, 1}, {0, 40, 1}, {0, 0, 2}, {40, 0, 2}, {0, 40, 2}},
                {{0, 1, 2}, {3, 4, 5}});
    if (near_first) std::swap(mesh.triangles[0], mesh.triangles[1]);
    mesh.triangle_element = {0, 1};
    mesh.elements = {{"first", "", {}}, {"second", "", {}}};
    const Film film = film_of(mesh, pixel_camera(40), 40, 40);
    EXPECT_EQ(film.at(5, 30).element, near_first ? 0U : 1U);
    EXPECT_FLOAT_EQ(film.at(5, 30).depth, 2);
    EXPECT_EQ(film.at(39, 0).element, kNothingSeen);
  }
}

TEST(MeshFilm, DepthOfASlopedTriangleIsThatOfItsPlane) {
  const auto z = [](double x, double y) { return 0.3 * x - 0.2 * y + 7; };
  const TriangleMesh mesh =
      mesh_of({{1, 2, z(1, 2)}, {47, 5, z(47, 5)}, {20, 44, z(20, 44)}}, {{0, 1, 2}});
  const Film film = film_of(mesh, pixel_camera(48), 48, 48);
  std::size_t inner = 0;
  for (std::size_t j = 0; j < 48; ++j) {
    for (std::size_t i = 0; i < 48; ++i) {
      if (film.at(i, j).cover < 1) continue;
      ++inner;
      EXPECT_NEAR(static_cast<double>(film.at(i, j).depth),
                  z(static_cast<double>(i) + 0.5, 47.5 - static_cast<double>(j)), 1e-4);
    }
  }
  EXPECT_GT(inner, 800U);
}

TEST(PlanFilm, EveryPixelHasTheElementAndHeightOfTheSurface) {
  const CompoundSurface surface = test::fixture("fig6");
  const Palette palette = palette_of(surface);
  Paint paint;
  paint.palette = &palette;
  const Camera camera =
      make_camera(View::kPlan, {Vec3(1, 1, 0), Vec3(39, 39, 0)}, {0, 0, 190, 190});
  Film film(200, 190);
  film_plan(surface, camera, paint, 2, film);
  std::size_t compared = 0;
  for (std::size_t j = 0; j < film.height; ++j) {
    for (std::size_t i = 0; i < film.width; ++i) {
      const FilmPixel& pixel = film.at(i, j);
      const double x = 1 + (static_cast<double>(i) + 0.5) / 5,
                   y = 39 - (static_cast<double>(j) + 0.5) / 5;
      if (i >= 190) {
        EXPECT_EQ(pixel.cover, 0) << "outside the domain";
        continue;
      }
      // Where the pixel's corners agree, everything in it does on this part.
      const auto at = surface.at(x, y);
      bool one = at.has_value();
      for (const double dx : {-0.1, 0.1}) {
        for (const double dy : {-0.1, 0.1}) {
          const auto corner =
              surface.at(std::clamp(x + dx, 1.0, 39.0), std::clamp(y + dy, 1.0, 39.0));
          one = one && corner && corner->surface == at->surface && corner->face == at->face;
        }
      }
      if (!one) continue;
      ++compared;
      EXPECT_EQ(palette[pixel.element].name,
                surface.element_name(make_label(at->row, static_cast<std::uint32_t>(at->face))));
      EXPECT_NEAR(pixel.cover, 1, 1e-6);
      // Within the slope over half a pixel.
      EXPECT_NEAR(static_cast<double>(pixel.depth), at->z,
                  0.15 * std::hypot(at->n.x(), at->n.y()) / at->n.z() + 0.02);
    }
  }
  EXPECT_GT(compared, 30'000U);
}

TEST(Preview, SameBytesForAnyNumberOfThreads) {
  const CompoundSurface surface = test::fixture("fig6");
  for (const View view : {View::kPlan, View::kIso}) {
    PreviewOptions options;
    options.size = {320, 240};
    options.view = view;
    options.threads = 1;
    const Result<Picture> one = preview(surface, options);
    options.threads = 5;
    const Result<Picture> five = preview(surface, options);
    ASSERT_TRUE(one && five);
    EXPECT_EQ(one->rgb, five->rgb);
  }
}

// A plate is the lowest there is of the surface, so it has the colour of the scale's foot, purple;
// were the block under it on the scale, it would be green.
TEST(Preview, TheScaleOfHeightsIsTheSurfacesOwn) {
  const CompoundSurface surface = test::surface_of(
      "SOLID-DEF\nS1,SPHER\nP1,0,0,0\nRAD,2\nBSURF-DEF\nPLANE,0\nBOOLE-DEF\nB+S1\n"
      "MACHI-DEF\nX-RNG,-10,10\nY-RNG,-10,10\n");
  PreviewOptions options;
  options.size = {320, 240};
  options.coloring = Coloring::kHeight;
  options.bare = true;
  const Result<Picture> picture = preview(surface, options);
  ASSERT_TRUE(picture);
  std::size_t purple = 0, green = 0;
  for (std::size_t k = 0; k < picture->rgb.size(); k += 3) {
    const int r = picture->rgb[k], g = picture->rgb[k + 1], b = picture->rgb[k + 2];
    purple += r > g + 20 && b > g + 20 ? 1 : 0;
    green += g > r + 20 ? 1 : 0;
  }
  EXPECT_GT(purple, 10 * green);
  EXPECT_GT(purple, 10'000U);
}

TEST(Preview, WantsTrianglesAndASurfaceForDeviations) {
  PreviewOptions options;
  EXPECT_EQ(preview(TriangleMesh{}, options).error().code, ErrorCode::kInput);
  options.coloring = Coloring::kDeviation;
  const TriangleMesh mesh = mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
  EXPECT_EQ(preview(mesh, options).error().code, ErrorCode::kUsage);
}

TEST(SharpEdges, ThoseOfACubeWithoutItsDiagonalsWhetherWeldedOrNot) {
  std::vector<Vec3> corners;
  for (int k = 0; k < 8; ++k) corners.emplace_back(k & 1, k >> 1 & 1, k >> 2);
  const TriangleMesh cube = mesh_of(corners, {{0, 2, 1},
                                              {1, 2, 3},
                                              {4, 5, 6},
                                              {5, 7, 6},
                                              {0, 1, 4},
                                              {1, 5, 4},
                                              {2, 6, 3},
                                              {3, 6, 7},
                                              {0, 4, 2},
                                              {2, 4, 6},
                                              {1, 3, 5},
                                              {3, 7, 5}});
  EXPECT_EQ(sharp_edges(cube, 30).size(), 12U);
  EXPECT_EQ(sharp_edges(cube, 91).size(), 0U);
  TriangleMesh apart;
  for (const auto& each : cube.triangles) {
    const auto first = static_cast<std::uint32_t>(apart.positions.size());
    for (const std::uint32_t v : each) apart.positions.push_back(cube.positions[v]);
    apart.triangles.push_back({first, first + 1, first + 2});
  }
  EXPECT_EQ(sharp_edges(apart, 30).size(), 12U);
  TriangleMesh open = cube;
  open.triangles.resize(10);
  std::size_t ends = 0;
  for (const MeshCurve& each : sharp_edges(open, 30)) ends += each.kind == CurveKind::kEdge ? 1 : 0;
  EXPECT_EQ(ends, 4U);
}

TEST(StrokeMask, CoversTheAreaOfTheStroke) {
  StrokeMask mask(100, 60);
  mask.add(Vec2(10.3, 12.8), Vec2(85.1, 44.6), 3);
  double sum = 0;
  for (std::size_t k = 0; k < 6000; ++k) sum += static_cast<double>(mask.at(k));
  const double length = std::hypot(85.1 - 10.3, 44.6 - 12.8);
  EXPECT_NEAR(sum, 3 * length + 3.14159 * 1.5 * 1.5, 4);
}

TEST(Lettering, StringsAreAsWideAsTheirStrokesAndCapitalsAsTall) {
  for (const std::string_view text : {"H", "S2.side", "-0.25 mm"}) {
    double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
    for (const Stroke& stroke : text_strokes(text, Vec2(50, 40), 21)) {
      for (const Vec2& p : stroke) {
        left = std::min(left, p.x()), right = std::max(right, p.x());
        top = std::min(top, p.y()), bottom = std::max(bottom, p.y());
      }
    }
    EXPECT_GE(left, 50);
    EXPECT_LE(right, 50 + text_width(text, 21));
    if (text == "H") {
      EXPECT_EQ(top, 19);
      EXPECT_EQ(bottom, 40);
    }
  }
  EXPECT_EQ(text_width("\x7f\xff", 21), text_width("?"
                                                   "?",
                                                   21));
}

TEST(ScaleBar, LengthsAreRound) {
  EXPECT_DOUBLE_EQ(round_length(9.9), 5);
  EXPECT_DOUBLE_EQ(round_length(4.99), 2);
  EXPECT_DOUBLE_EQ(round_length(0.0012), 0.001);
  EXPECT_DOUBLE_EQ(round_length(20), 20);
}

}  // namespace
}  // namespace diesink
