#include "sightline/apps/report/answer.h"

#include <algorithm>

#include "sightline/apps/common/svg_canvas.h"

namespace sightline::apps {
namespace {

constexpr double kAsGood = 1.1;         // times the error of exact surfaces
constexpr double kLeastLength = 1e-6;   // metres that are told apart
constexpr double kUsualCoarse = 0.030;  // metres: the coarse triangles that the sentence names, if they were measured

std::string time_words(double ms) {
  return short_number(ms, ms < 100.0 ? 2 : 3) + " ms";
}

/// "18 times as long", "1.3 times as fast", "about as long".
std::string compared(double ms, double with) {
  constexpr double kSame = 1.1;
  if (ms > kSame * with) return short_number(ms / with, 2) + " times as long";
  if (ms * kSame < with) return short_number(with / ms, 2) + " times as fast";
  return "about as long";
}

/// "(tolerance 3 mm) take 45 ms, 1.3 times as long"
std::string cost(const SurfaceCost& triangles, const SurfaceCost& exact) {
  return "(tolerance " + length_words(triangles.tolerance) + ") take " + time_words(triangles.ms) + ", " +
         compared(triangles.ms, exact.ms);
}

/// The coarsest with such an error or less; null: none.
const SurfaceCost* first_within(const std::vector<SurfaceCost>& triangles, double error) {
  const auto found =
      std::find_if(triangles.begin(), triangles.end(), [&](const SurfaceCost& t) { return t.error <= error; });
  return found == triangles.end() ? nullptr : &*found;
}

/// The coarsest of those that are about as near as any: rasterisers round corners, so finer ones may be no nearer.
const SurfaceCost& nearest_of(const std::vector<SurfaceCost>& triangles) {
  const auto least = std::min_element(triangles.begin(), triangles.end(),
                                      [](const SurfaceCost& a, const SurfaceCost& b) { return a.error < b.error; });
  return *first_within(triangles, kAsGood * least->error);
}

const SurfaceCost& coarse_of(const std::vector<SurfaceCost>& triangles) {
  const auto usual = std::find_if(triangles.begin(), triangles.end(),
                                  [](const SurfaceCost& t) { return t.tolerance <= 1.001 * kUsualCoarse; });
  return usual == triangles.end() ? triangles.back() : *usual;
}

/// ", which lie up to 0.019 mm off their file's surfaces,", or nothing where they lie in them or are the file's own.
std::string off_words(const AnswerResults& results) {
  if (results.mesh_deviation < kLeastLength) return "";
  return ", which lie up to " + length_words(results.mesh_deviation) + " off the surfaces of their file,";
}

/// A sentence on how the model is drawn, how long that takes, and how near it is.
std::string drawn_words(const AnswerResults& results) {
  const SurfaceCost& exact = results.exact;
  const double error = exact.error + (results.solid_deviation < kLeastLength ? 0.0 : results.solid_deviation);
  const std::string precision = length_words(std::max(error, kLeastLength)), time = time_words(exact.ms);
  if (results.meshes == 0)
    return "Exact surfaces take " + time + " a frame and are drawn within " + precision + " of the true ones";
  const auto items = [](std::uint64_t count) { return std::to_string(count) + (count == 1 ? " item" : " items"); };
  return "Exact surfaces of " + items(results.solids) + " and triangles of " + items(results.meshes) +
         off_words(results) + " take " + time + " a frame and are drawn within " + precision + " of where they are";
}

}  // namespace

std::string length_words(double metres) {
  if (metres > 0.0 && metres < kLeastLength) return "under 0.001 mm";
  const bool small = metres < 1.0;
  const double value = small ? 1e3 * metres : metres;
  return short_number(value, value < 100.0 ? 2 : 3) + (small ? " mm" : " m");
}

std::string answer_sentence(const AnswerResults& results) {
  const SurfaceCost& exact = results.exact;
  const std::vector<SurfaceCost>& triangles = results.triangles;
  if (results.solids == 0)
    return "The model has no solid primitives: its triangles" + off_words(results) + " take " + time_words(exact.ms) +
           " a frame, and are drawn within " + length_words(std::max(exact.error, kLeastLength)) +
           " of where they are.";
  std::string sentence = drawn_words(results);
  if (triangles.empty()) return sentence + "; triangles were not measured.";
  const SurfaceCost& best = nearest_of(triangles);
  const SurfaceCost* good = first_within(triangles, kAsGood * exact.error);
  if (good)
    sentence += "; triangles as good " + cost(*good, exact);
  else
    sentence +=
        "; no triangles measured come nearer than " + length_words(best.error) + ", and these " + cost(best, exact);
  const SurfaceCost &coarse = coarse_of(triangles), &named = good ? *good : best;
  if (named.tolerance < coarse.tolerance)
    sentence += "; coarse ones " + cost(coarse, exact) + ", and are " + length_words(coarse.error) + " off";
  return sentence + ".";
}

}  // namespace sightline::apps
