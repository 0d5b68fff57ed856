// Random part programs by the thousand, each tessellated open or solid, coarse or fine, and proved.
// A process of its own for each, so that one that breaks or hangs is told and the rest go on.
// usage: tessellation_soak FIRST COUNT [FOLDER]     FOLDER takes the programs that failed
//        tessellation_soak --small FIRST COUNT [MOST]
//                      small and coarse ones, for every run of the tests; every kind of solid and
//                      base has to be among them, curves have to lie on their faces; MOST of them
//                      may fail (0)
//        tessellation_soak --coarse FIRST COUNT [FOLDER]
//                      small ones with tolerances up to ten times the part, up to 1e7 mm away from
//                      the origin
//        tessellation_soak --part FILE [TOLERANCE]  one program, all schemes
//        tessellation_soak --cases FOLDER           writes the named degenerate dies there
// SPDX-License-Identifier: Apache-2.0
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <vector>

#include "core/solids/kinds.h"
#include "tests/support/load_part.h"
#include "tests/support/mesh_proof.h"
#include "tests/support/named_cases.h"

namespace diesink::test {
namespace {

constexpr rlim_t kSeconds = 60;  // of the processor, a trial
// Of the small ones: the largest distance of a curve's vertex to its faces, of the size, and how
// many may tell an area that is not certified.
constexpr double kMostResidual = 1e-12;
constexpr std::size_t kMostTold = 3;

struct Trial {
  std::string text;
  std::string regridded;  // the same with another X-INT and Y-INT; empty where that is not asked
  ProofOptions options;
  bool whole_only = false;  // no more is asked of it than that the mesh is there and whole
};

// What trials are drawn from.
struct TrialKind {
  std::uint64_t series;  // parts the seeds of one kind from another's
  int most_solids;
  std::array<double, 2> bodies;    // their least and largest extent, of the program's size
  std::vector<double> tolerances;  // of the program's size
  int samples;
  bool regrid;  // every fourth seed again with another X-INT and Y-INT
};

const TrialKind kHeavy{0x5EED, 24, {0.04, 0.16}, {1e-4, 3e-4, 1e-3, 1e-2}, 1000, false};
// Some hundredths of a second each.
const TrialKind kSmall{0x5A11, 5, {0.1, 0.25}, {1e-3, 3e-3, 1e-2}, 200, true};

// What is left of a part where the tolerance, or the digits that far coordinates leave, are wider
// than its features: a mesh, and what it cannot show is told.
const TrialKind kCoarse{0xC0A5, 8, {0.02, 0.25}, {0.02, 0.1, 0.5, 2, 10}, 50, false};
constexpr double kFarther[] = {0, 1e3, 1e5, 1e6, 1e7};  // moved by so many millimetres

// Seeds walk through sizes, numbers of solids, tolerances and both kinds of mesh.
Trial trial_of(const TrialKind& kind, std::uint64_t seed) {
  Trial trial;
  Random random(seed ^ kind.series);
  constexpr double kSizes[] = {100, 100, 100, 1e-3, 1e4};
  RandomProgramOptions program;
  program.size = kSizes[random.below(5)];
  program.solids = 1 + random.below(kind.most_solids);
  program.body = program.size * random.uniform(kind.bodies[0], kind.bodies[1]);
  trial.text = random_part_program(seed, program);
  TessellationOptions& how = trial.options.tessellation;
  how.tolerance = kind.tolerances[static_cast<std::size_t>(
                      random.below(static_cast<int>(kind.tolerances.size())))] *
                  program.size;
  how.solid = random.chance(0.5);
  how.scheme = random.chance(0.15) ? MeshScheme::kGrid : MeshScheme::kAdaptive;
  how.threads = 1;
  trial.options.seed = seed;
  trial.options.samples = kind.samples;
  trial.options.may_be_empty = true;
  if (&kind == &kCoarse) {
    // Every other one with searches given up almost at once, so that what cells join is wrong.
    if (seed % 2 == 0) how.budget = {40, 0, 64, 0, 1};
    const double by = kFarther[random.below(5)];
    const std::string far = moved(trial.text, by);
    try {
      surface_of(far);
      trial.text = far;
      trial.whole_only = seed % 2 == 0 || by > 1e7 * program.size;
    } catch (const std::exception&) {
      // Rounding has bent a polyhedron's faces: refused when it is read, so it stays at home.
      trial.whole_only = seed % 2 == 0;
    }
  }
  if (kind.regrid && seed % 4 == 0 && how.scheme == MeshScheme::kAdaptive) {
    program.interval = program.size / 7.3;
    trial.regridded = random_part_program(seed, program);
  }
  return trial;
}

// All faults of one trial.
std::string faults_of_trial(const Trial& trial, ProofFigures& figures) {
  const CompoundSurface surface = surface_of(trial.text);
  if (trial.whole_only) {
    const Result<Tessellation> made = tessellate(surface, trial.options.tessellation);
    if (!made) {
      const std::string error = to_text(made.error());
      return error.find("no vertical line") != std::string::npos ? "" : "refused: " + error + '\n';
    }
    figures.uncertified = made->report.uncertified_area;
    Faults faults;
    check_topology(made->mesh, trial.options.tessellation.solid, faults);
    return faults.text();
  }
  std::string faults = prove(surface, trial.options, &figures);
  if (trial.regridded.empty()) return faults;
  const Result<Tessellation> one = tessellate(surface, trial.options.tessellation);
  const Result<Tessellation> other =
      tessellate(surface_of(trial.regridded), trial.options.tessellation);
  if (one.has_value() != other.has_value() || (one && !same_bytes(one->mesh, other->mesh)))
    faults += "another mesh for another X-INT and Y-INT\n";
  return faults;
}

// The faults of one trial, found in a child; or how the child ended.
std::string run_apart(const Trial& trial, ProofFigures& figures) {
  int ends[2];
  if (pipe(ends) != 0) return "no pipe\n";
  const pid_t child = fork();
  if (child < 0) return "no process\n";
  if (child == 0) {
    close(ends[0]);
    const rlimit limit{kSeconds, kSeconds + 1};
    setrlimit(RLIMIT_CPU, &limit);
    std::string faults;
    try {
      faults = faults_of_trial(trial, figures);
    } catch (const std::exception& e) {
      faults = std::string("exception: ") + e.what() + '\n';
    }
    char measured[sizeof figures];
    std::memcpy(measured, &figures, sizeof figures);
    faults.insert(0, measured, sizeof figures);
    const char* at = faults.data();
    for (std::size_t left = std::min<std::size_t>(faults.size(), 4000); left > 0;) {
      const ssize_t done = write(ends[1], at, left);
      if (done <= 0) _exit(3);
      at += done;
      left -= static_cast<std::size_t>(done);
    }
    _exit(0);
  }
  close(ends[1]);
  std::string faults;
  char buffer[4096];
  for (ssize_t got = 0; (got = read(ends[0], buffer, sizeof buffer)) > 0;)
    faults.append(buffer, static_cast<std::size_t>(got));
  close(ends[0]);
  if (faults.size() >= sizeof figures) {
    std::memcpy(&figures, faults.data(), sizeof figures);
    faults.erase(0, sizeof figures);
  }
  int status = 0;
  waitpid(child, &status, 0);
  if (WIFSIGNALED(status))
    faults += WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL
                  ? "took over a minute\n"
                  : "broke with signal " + std::to_string(WTERMSIG(status)) + '\n';
  return faults;
}

// A fault's kind: its words before the figures.
std::string kind_of(const std::string& line) {
  return line.substr(0, line.find(line.starts_with("refused") ? '\0' : ':'));
}

// What part programs have been made of: types of solids, signs, groups, kinds of base.
void note_kinds(const CompoundSurface& surface, std::set<std::string>& kinds) {
  const PartProgram& program = surface.program();
  for (const Solid& solid : program.solids) kinds.emplace(solid.type);
  int depth = 0;
  for (const BooleanStep& step : program.boole) {
    if (step.kind == BooleanStep::Kind::kGroupOpen && depth++ == 0) kinds.insert("group");
    if (step.kind == BooleanStep::Kind::kGroupOpen && depth > 1) kinds.insert("group in a group");
    if (step.kind == BooleanStep::Kind::kGroupClose) --depth;
    if (step.kind == BooleanStep::Kind::kTerm)
      kinds.insert(step.sign == Sign::kMinus ? "minus" : "plus");
  }
  if (std::holds_alternative<PlaneBase>(program.base)) {
    kinds.insert("plane");
  } else if (std::holds_alternative<FergusonSurface>(surface.impl().base)) {
    const auto& ferguson = std::get<FergusonSurface>(surface.impl().base);
    kinds.insert(ferguson.affine() ? "Ferguson, affine" : "Ferguson, warped");
  } else {
    kinds.insert("no base");
  }
}

int soak(const TrialKind& kind, std::uint64_t first, std::uint64_t count, const std::string& folder,
         std::size_t most) {
  const bool small = &kind == &kSmall;
  std::map<std::string, std::size_t> kinds;
  std::set<std::string> made_of;
  std::size_t failed = 0;
  std::vector<std::string> uncertified;
  double residual = 0;
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    const Trial trial = trial_of(kind, seed);
    if (small) note_kinds(surface_of(trial.text), made_of);
    ProofFigures figures;
    const std::string faults = run_apart(trial, figures);
    residual = std::max(residual, figures.residual);
    const TessellationOptions& t = trial.options.tessellation;
    // The grid scheme bounds nothing between its nodes.
    if (figures.uncertified > 0 && t.scheme == MeshScheme::kAdaptive)
      uncertified.push_back(std::to_string(seed));
    if (faults.empty()) continue;
    ++failed;
    std::printf("seed %llu (%s%s, tolerance %.3g)\n%s", static_cast<unsigned long long>(seed),
                t.scheme == MeshScheme::kGrid ? "grid" : "adaptive", t.solid ? ", solid" : "",
                t.tolerance, faults.c_str());
    std::fflush(stdout);
    std::istringstream lines(faults);
    for (std::string line; std::getline(lines, line);) ++kinds[kind_of(line)];
    if (!folder.empty()) {
      std::ofstream file(folder + "/" + std::to_string(seed) + ".part");
      std::istringstream told(faults);
      for (std::string line; std::getline(told, line);) file << "$$ " << line << '\n';
      file << trial.text;
    }
  }
  std::printf("%zu of %llu failed\n", failed, static_cast<unsigned long long>(count));
  for (const auto& [name, times] : kinds) std::printf("%6zu  %s\n", times, name.c_str());
  std::printf("largest distance of a curve's vertex to its faces: %.2g of the size\n", residual);
  std::printf("%zu adaptive meshes tell an area that is not certified", uncertified.size());
  for (std::size_t k = 0; k < uncertified.size(); ++k)
    std::printf("%s%s", k == 0 ? ": " : " ", uncertified[k].c_str());
  std::printf("\n");
  if (!small) return failed <= most ? 0 : 1;
  failed = failed <= most ? 0 : failed;
  if (residual > kMostResidual || uncertified.size() > kMostTold) {
    std::printf("more than %.2g, or %zu\n", kMostResidual, kMostTold);
    ++failed;
  }
  // All that a part program can be made of has been among them.
  for (const SolidKind* one : solid_kinds()) {
    if (made_of.contains(std::string(one->keyword))) continue;
    std::printf("no %s among them\n", std::string(one->keyword).c_str());
    ++failed;
  }
  for (const char* word : {"plus", "minus", "group", "group in a group", "plane", "no base",
                           "Ferguson, affine", "Ferguson, warped"}) {
    if (made_of.contains(word)) continue;
    std::printf("no %s among them\n", word);
    ++failed;
  }
  return failed == 0 ? 0 : 1;
}

int one_part(const std::string& path, double tolerance) {
  std::ifstream file(path, std::ios::binary);
  Trial trial;
  trial.text.assign(std::istreambuf_iterator<char>(file), {});
  int failed = 0;
  for (const MeshScheme scheme : {MeshScheme::kAdaptive, MeshScheme::kGrid}) {
    for (const bool solid : {false, true}) {
      trial.options.tessellation.scheme = scheme;
      trial.options.tessellation.solid = solid;
      trial.options.tessellation.tolerance = tolerance;
      ProofFigures figures;
      const std::string faults = run_apart(trial, figures);
      std::printf("%s%s: %s", scheme == MeshScheme::kGrid ? "grid" : "adaptive",
                  solid ? ", solid" : "", faults.empty() ? "well\n" : ("\n" + faults).c_str());
      failed += faults.empty() ? 0 : 1;
    }
  }
  return failed == 0 ? 0 : 1;
}

}  // namespace
}  // namespace diesink::test

int main(int count, char** words) {
  using namespace diesink::test;
  const std::string first = count > 1 ? words[1] : "";
  if (first == "--part" && count > 2)
    return one_part(words[2], count > 3 ? std::atof(words[3]) : 0);
  if (first == "--cases" && count > 2) {
    for (const NamedCase& c : named_cases())
      std::ofstream(std::string(words[2]) + "/" + c.name + ".part") << c.text;
    return 0;
  }
  const TrialKind& kind = first == "--small" ? kSmall : first == "--coarse" ? kCoarse : kHeavy;
  const bool small = &kind == &kSmall;
  if (count < (&kind == &kHeavy ? 3 : 4)) {
    std::fprintf(
        stderr,
        "usage: tessellation_soak FIRST COUNT [FOLDER] | --small FIRST COUNT [MOST] | --coarse "
        "FIRST COUNT [FOLDER] | --part FILE [TOLERANCE]\n");
    return 1;
  }
  const int at = &kind == &kHeavy ? 1 : 2;
  const std::string last = count > at + 2 ? words[at + 2] : "";
  return soak(kind, std::strtoull(words[at], nullptr, 10),
              std::strtoull(words[at + 1], nullptr, 10), small ? "" : last,
              small ? std::strtoull(last.c_str(), nullptr, 10) : 0);
}
