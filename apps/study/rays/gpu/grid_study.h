// The tables of G. Ordeix, S. Cioli, "Computación Gráfica sobre GPUs" (2010), chapter 5: images a second against the
// size of the uniform grid, which the CPU builds, on the CPU and on the GPU.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sightline/apps/study/rays/benchmark.h"
#include "sightline/apps/study/rays/generated_meshes.h"
#include "sightline/apps/study/rays/gpu/tracer.h"

namespace sightline::study::rays {

struct GridScene {
  std::string name, tables;  ///< as the dissertation has them
  GeneratedMesh mesh;
  int lights = 1;
  std::vector<int> sizes;  ///< cells along each axis
};

/// The dissertation's scenes, made up by what it says of them. Those of scanned models are generated scans.
std::vector<GridScene> grid_scenes();

/// An image: the primary rays, and from each hit a shadow ray to each light. Rays are made ready beforehand.
struct GridImage {
  int size = 0;
  std::size_t references = 0;
  double build_ms = 0.0;
  double cpu_ms = 0.0, gpu_ms = 0.0;  ///< to trace
  std::size_t lit = 0;                ///< shadow rays that reach their light, as the CPU finds
  std::size_t disagreements = 0;      ///< primary rays, and how far the GPU's number of lit ones is off
};

struct GridRun {
  const GridScene* scene = nullptr;
  std::size_t triangles = 0;
  std::vector<GridImage> images;  ///< by size
};

/// Times are the least of `passes` (>= 1): processor time of one thread, and as seconds_on_gpu() has it.
core::Expected<GridRun> run_grids(const gl::Context& context, GpuTracer& tracer, const GridScene& scene,
                                  const Image& image, int passes, const std::function<void(const std::string&)>& step);

}  // namespace sightline::study::rays
