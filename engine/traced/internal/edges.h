// Lines over an image in main memory: twin of render/shaders/edge.vert, edge.frag and put_edges.frag. Internal to
// engine.
#pragma once

#include <span>

#include "sightline/core/thread_pool.h"
#include "sightline/core/view.h"
#include "sightline/engine/internal/edge_lists.h"
#include "sightline/engine/traced/internal/depth_shading.h"

namespace sightline::engine {

/// Draws lines over the colours, as render/internal/edge_lines.h has them. `sample_place`: of what the image's depths
/// are known for, in each pixel, from its lower left corner. A GPU's result differs by the rounding of floats, and so
/// by a step of visibility in single pixels.
void draw_edges(const ShadedImage& image, const glm::vec2& sample_place, const core::View& view, const EdgeLists& lists,
                const render::LineStyle& style, core::ThreadPool& threads);

}  // namespace sightline::engine
