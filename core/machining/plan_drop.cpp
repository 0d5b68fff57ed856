// The drop method: profiles of the offset surface, pass by pass, and their fit.
// Budget of the tolerances: the mesh lies at most `deviation` from the surface, the chords of the
// profile at most `chord` under the tip's true height, the moves at most `below` under and `above`
// over the profile. Where one of INTOL and OUTTOL leaves too little for that, a cutter grown (or
// shrunk) by `grow` all round is dropped in place of the real one, which then keeps that distance
// from the mesh.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/machining/path_fit.h"
#include "core/machining/path_interval.h"
#include "core/machining/path_links.h"
#include "core/machining/row_blocks.h"
#include "core/machining/tool_path_plan.h"
#include "core/number.h"
#include "core/parallel.h"

namespace diesink {
namespace {

constexpr std::size_t kPassesABlock = 8;
// Passes come no closer than on a slope of 80 degrees: nearer to upright the interval would vanish.
constexpr double kSteepest = 0.17364817766693033;

Error input_error(std::string message) { return {ErrorCode::kInput, std::move(message), {}}; }

// The domain in the turned frame: where a pass at y begins and ends.
class FrameDomain {
 public:
  FrameDomain(const OffsetSurface& offset, const std::array<double, 4>& d) {
    const std::array<Vec3, 4> corners{Vec3(d[0], d[2], 0), Vec3(d[1], d[2], 0), Vec3(d[1], d[3], 0),
                                      Vec3(d[0], d[3], 0)};
    for (std::size_t k = 0; k < 4; ++k) corners_[k] = offset.to_frame(corners[k]).head<2>();
    low_ = high_ = corners_[0].y();
    for (const Vec2& c : corners_) {
      low_ = std::fmin(low_, c.y());
      high_ = std::fmax(high_, c.y());
    }
    // Passes begin at the side of the program's own first corner.
    from_high_ = corners_[0].y() - low_ > high_ - corners_[0].y();
  }
  [[nodiscard]] double low() const { return low_; }
  [[nodiscard]] double high() const { return high_; }
  [[nodiscard]] bool from_high() const { return from_high_; }
  [[nodiscard]] Span pass(double y) const {
    Span span;
    for (std::size_t k = 0; k < 4; ++k) {
      const Vec2 &p = corners_[k], &q = corners_[(k + 1) % 4];
      if (y < std::fmin(p.y(), q.y()) || y > std::fmax(p.y(), q.y())) continue;
      const auto add = [&](double x) {
        span.x0 = std::fmin(span.x0, x);
        span.x1 = std::fmax(span.x1, x);
      };
      if (p.y() == q.y()) {
        add(p.x());
        add(q.x());
      } else {
        add(p.x() + (y - p.y()) / (q.y() - p.y()) * (q.x() - p.x()));
      }
    }
    return span;
  }

 private:
  std::array<Vec2, 4> corners_;
  double low_ = 0, high_ = 0;
  bool from_high_ = false;
};

// Curvature of the surface under a triangle along its tangent e, from the corner normals; 0 without
// them.
double curvature_along(const TriangleMesh& mesh, std::uint32_t triangle, const Vec3& e) {
  if (mesh.corner_normals.size() != mesh.triangles.size()) return 0;
  const auto& t = mesh.triangles[triangle];
  const auto& n = mesh.corner_normals[triangle];
  const Vec3 a = mesh.positions[t[1]] - mesh.positions[t[0]];
  const Vec3 b = mesh.positions[t[2]] - mesh.positions[t[0]];
  const double aa = a.dot(a), ab = a.dot(b), bb = b.dot(b), det = aa * bb - ab * ab;
  if (!(det > 1e-12 * aa * bb)) return 0;
  const double ea = e.dot(a), eb = e.dot(b);
  const double u = (ea * bb - eb * ab) / det, v = (eb * aa - ea * ab) / det;
  const Vec3 dn =
      u * (mesh.normals[n[1]] - mesh.normals[n[0]]) + v * (mesh.normals[n[2]] - mesh.normals[n[0]]);
  return dn.dot(e);
}

struct Work {
  std::vector<std::vector<ProfileSegment>> rows;  // of the block
  UpperEnvelope envelope;
};

// Calls visit(row, profile) with the profile of every row, blocks of rows in parallel.
template <class Visit>
void each_profile(const OffsetSurface& offset, const FrameDomain& domain,
                  const std::vector<double>& ys, double chord, int threads, const Visit& visit) {
  const RowBlocks blocks(offset, ys, kPassesABlock);
  std::vector<Work> work(static_cast<std::size_t>(thread_count(threads)));
  parallel_blocks(ys.size(), kPassesABlock, threads,
                  [&](std::size_t begin, std::size_t end, int worker) {
                    Work& w = work[static_cast<std::size_t>(worker)];
                    w.rows.resize(kPassesABlock);
                    for (auto& row : w.rows) row.clear();
                    std::array<Span, kPassesABlock> spans;
                    for (std::size_t j = begin; j < end; ++j) spans[j - begin] = domain.pass(ys[j]);
                    blocks.for_each(begin, end, [&](std::uint32_t piece, std::size_t j) {
                      const Span& span = spans[j - begin];
                      slice_piece(offset, piece, ys[j], span.x0, span.x1, chord, w.rows[j - begin]);
                    });
                    for (std::size_t j = begin; j < end; ++j) {
                      w.envelope.take(w.rows[j - begin]);
                      visit(j, w.rows[j - begin]);
                    }
                  });
}

// Pass positions with a fixed interval: the first and last on the domain's border, equal steps.
std::vector<double> even_passes(const FrameDomain& domain, double interval) {
  const double width = domain.high() - domain.low();
  const double steps = std::fmax(1, std::ceil(width / interval - 1e-9));
  std::vector<double> ys;
  for (double k = 0; k < steps; ++k) ys.push_back(domain.low() + width * (k / steps));
  ys.push_back(domain.high());
  return ys;
}

// Pass positions from the cusp height: every contact of a row sets a limit, rows half a level
// interval apart are examined, and a step is the longest that keeps the limits of all rows it
// passes.
std::vector<double> cusp_passes(const OffsetSurface& offset, const TriangleMesh& mesh,
                                const FrameDomain& domain, const CutterShape& cutter, double cusp,
                                double chord, int threads) {
  const Vec3 direction = offset.from_frame(Vec3::UnitX());
  const Vec2 along = direction.head<2>();
  const double level = drop_interval(cutter, Vec3::UnitZ(), along, 0, cusp);
  const double least =
      kSteepest * std::fmin(level, cusp_interval(std::fmax(cutter.corner(), cusp), 0, cusp));
  const std::vector<double> rows = even_passes(domain, level / 2);
  std::vector<double> limits(rows.size(), 2 * cutter.radius());
  each_profile(offset, domain, rows, chord, threads,
               [&](std::size_t j, const std::vector<ProfileSegment>& profile) {
                 std::uint32_t last = 0xFFFFFFFFu;
                 for (const ProfileSegment& s : profile) {
                   if (s.piece >= offset.facets().size() || s.piece == last) continue;
                   last = s.piece;
                   const std::uint32_t triangle = offset.facets()[s.piece].triangle;
                   const auto& t = mesh.triangles[triangle];
                   const Vec3 n = (mesh.positions[t[1]] - mesh.positions[t[0]])
                                      .cross(mesh.positions[t[2]] - mesh.positions[t[0]])
                                      .normalized();
                   const double curvature = curvature_along(mesh, triangle, across_of(n, along));
                   limits[j] =
                       std::fmin(limits[j], drop_interval(cutter, n, along, curvature, cusp));
                 }
                 limits[j] = std::fmax(limits[j], least);
               });
  const auto strip = [&](std::size_t k) { return std::fmin(limits[k], limits[k + 1]); };
  std::vector<double> ys{domain.low()};
  std::size_t row = 0;
  while (ys.back() < domain.high()) {
    const double y = ys.back();
    while (row + 2 < rows.size() && rows[row + 1] <= y) ++row;
    double step = strip(row);
    for (std::size_t k = row + 1; k + 1 < rows.size() && rows[k] < y + step; ++k) {
      step = std::fmin(step, std::fmax(strip(k), rows[k] - y));
    }
    step = std::fmax(step, least);
    ys.push_back(y + step >= domain.high() ? domain.high() : y + step);
  }
  return ys;
}

}  // namespace

Result<PlannedPath> plan_drop_path(const TriangleMesh& mesh, double deviation,
                                   const std::array<double, 4>& domain,
                                   const PathOptions& options) {
  const Result<CutterShape> real = CutterShape::make(options.cutter);
  if (!real) return real.error();
  const double chord = (options.intol + options.outtol) / 64;
  // What the two tolerances leave once mesh, chords and controller have had theirs.
  const double blend = kBlendPart * std::fmin(options.intol, options.outtol);
  const double inside = options.intol - deviation - chord - blend;
  const double outside = options.outtol - deviation - blend;
  if (!(inside + outside > 0)) {
    return input_error(
        "the tolerances are too small for the mesh under the path, which deviates by " +
        number_text(deviation));
  }
  double grow = 0, below = inside, above = outside;
  if (std::fmin(inside, outside) < 0.1 * std::fmax(inside, outside)) {
    grow = std::fmax((outside - inside) / 2, -real->radius() / 2);
    below = above = (inside + outside) / 2;
  }
  const CutterShape cutter =
      *CutterShape::make({2 * (real->radius() + grow), std::fmax(0, real->corner() + grow)});
  const OffsetSurface offset(mesh, cutter, options.angle);
  const FrameDomain frame(offset, domain);

  double top = kNoContact, size = 0;
  for (const Vec3& p : mesh.positions) {
    top = std::fmax(top, p.z());
    size = std::fmax(size, p.cwiseAbs().maxCoeff());
  }
  const double clearance = options.clearance.value_or(top + options.cutter.diameter);
  if (!(clearance > top + grow)) {
    return input_error("the clearance plane " + number_text(clearance) +
                       " must lie above the surface, whose highest point is " + number_text(top));
  }

  std::vector<double> ys;
  if (options.interval) {
    ys = even_passes(frame, *options.interval);
  } else {
    ys = cusp_passes(offset, mesh, frame, *real, *options.cusp, chord, options.threads);
  }

  PlannedPath planned;
  std::vector<std::vector<PassRun>> passes(ys.size());
  const double join = 1e-7 * (real->radius() + 1e-3 * size);
  each_profile(offset, frame, ys, chord, options.threads,
               [&](std::size_t j, const std::vector<ProfileSegment>& profile) {
                 passes[j] = fit_runs(profile, below, above, join);
               });

  double widest = 0;
  planned.report.least_interval = ys.size() > 1 ? ys.back() - ys.front() : 0;
  for (std::size_t k = 1; k < ys.size(); ++k) {
    widest = std::fmax(widest, ys[k] - ys[k - 1]);
    planned.report.least_interval = std::fmin(planned.report.least_interval, ys[k] - ys[k - 1]);
  }
  planned.report.greatest_interval = widest;
  const TopGrid tops(offset, std::fmax(widest, real->radius() / 4));
  PathJoiner joiner(tops, grow, clearance, 2 * widest + real->radius());
  bool forward = true;
  for (std::size_t k = 0; k < ys.size(); ++k) {
    const std::size_t j = frame.from_high() ? ys.size() - 1 - k : k;
    std::vector<PassRun>& runs = passes[j];
    if (runs.empty()) continue;
    ++planned.report.passes;
    bool first = true;
    for (std::size_t r = 0; r < runs.size(); ++r) {
      const PassRun& run = runs[forward ? r : runs.size() - 1 - r];
      std::vector<Vec3> tips;
      tips.reserve(run.size());
      for (const Vec2& p : run) tips.emplace_back(p.x(), ys[j], p.y() + grow);
      if (!forward) std::reverse(tips.begin(), tips.end());
      joiner.cut(tips, !first || options.pattern == PathPattern::kOneway);
      first = false;
    }
    std::vector<PassRun>().swap(runs);
    if (options.pattern == PathPattern::kZigzag) forward = !forward;
  }
  planned.path.points = joiner.finish();
  if (planned.path.points.size() < 4) {
    return input_error("the cutter meets no surface in the domain: the path would be empty");
  }
  for (ClPoint& point : planned.path.points) point.tip = offset.from_frame(point.tip);
  planned.path.cutter = options.cutter;
  planned.path.intol = options.intol;
  planned.path.outtol = options.outtol;
  planned.path.clearance = clearance;
  planned.report.mesh_deviation = deviation;
  planned.report.overcut_bound = below - grow + chord + deviation + blend;
  planned.report.undercut_bound = above + grow + deviation + blend;
  measure(planned.path, planned.report);
  return planned;
}

}  // namespace diesink
