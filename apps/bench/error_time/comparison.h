// Error against time: ways to draw a model, whose images are compared with references and whose frames are timed in
// turns. What is measured is rows of JSON, from which tables and plots are made.
#pragma once

#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "sightline/apps/common/drawn_variant.h"
#include "sightline/apps/common/svg_plot.h"
#include "sightline/core/view.h"
#include "sightline/importers/json/internal/json.h"

namespace sightline::bench {

/// Milliseconds of wall clock, and of all threads of the process.
struct Took {
  double ms = 0.0, processor_ms = 0.0;
};

/// Values by the name of what they measure.
using Measures = std::map<std::string, std::vector<double>>;

/// A way to draw a model. Ways of one name differ by a threshold: pixels, or the segments of triangles.
struct Way {
  std::string name;
  double threshold = 0.0;
  std::function<core::Expected<Took>(const core::View&)> draw;  ///< until the image is complete
  /// The image that was drawn last. Adds what else is measured of it.
  std::function<apps::DrawnImage(const core::View&, Measures&)> image;
};

/// The image that ways are compared with, whose ids are those of the model's items.
using ReferenceOf = std::function<apps::DrawnImage(const core::View&)>;

/// Rows {"name", "threshold", and for each measure its statistics over the views}: "flip", "flip_p99", "psnr", "ssim",
/// "wrong_ids" and "wrong_ids_but_ties" (per cent of the pixels), "ms" and "processor_ms" (medians of `passes` frames
/// of a view), and what Way::image adds.
json::Value compare(const std::vector<Way>& ways, std::span<const core::View> views, int passes,
                    const ReferenceOf& reference);

/// A plot of error against cost: values of rows by JSON pointers without their first slash, as table.h has keys.
struct ErrorPlot {
  std::string file, title, x, x_label, y, y_label;
};

/// Rows of one name are a series, in their order, and a row alone is a point.
apps::Panel panel_of(const std::string& title, const json::Value& rows, const ErrorPlot& plot);
core::Expected<void> write_plot(const ErrorPlot& plot, std::vector<apps::Panel> panels);

}  // namespace sightline::bench
