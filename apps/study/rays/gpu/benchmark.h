// The traversals in GLSL on the rays of a benchmark.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sightline/apps/study/rays/benchmark.h"
#include "sightline/apps/study/rays/gpu/tracer.h"

namespace sightline::study::rays {

/// Seconds until the GPU has done what `work` asks of it: of the wall clock, from here until glFinish() returns. On
/// software rasterisers, where the processors' other work would count too, processor time of all their threads. Timer
/// queries would leave out the dispatch, and mean nothing on the latter.
double seconds_on_gpu(const gl::Context& context, const std::function<void()>& work);

/// Fills TraversalRun::gpu of every traversal of `result`. `step` as in run_benchmark(). Returns what is left out, a
/// line with the reason each: a traversal whose structure does not fit the GPU. Fails when the rays do not, or a shader
/// does not compile.
core::Expected<std::vector<std::string>> run_on_gpu(const gl::Context& context, const Structures& structures,
                                                    const BenchmarkRays& searched, int passes,
                                                    const std::function<void(const std::string&)>& step,
                                                    Benchmark& result);

}  // namespace sightline::study::rays
