// Images of what sightline-study recognise measures on. Only builds with GL have them.
#pragma once

#include <span>
#include <vector>

#include "sightline/apps/common/drawn_variant.h"
#include "sightline/study/parts/recognise/subjects.h"

namespace sightline::bench {

/// Errors of images against those of the primitives, means over the views.
struct MeanErrors {
  double flip = 0.0;       ///< mean over all pixels
  double wrong_ids = 0.0;  ///< share of pixels that show another item, or an item in just one of the images
};

/// Frames of the tour through a scene, with its primitives and with what stands for them.
class Images {
 public:
  /// `scene` is committed. It and `originals` must outlive the images.
  static core::Expected<Images> create(core::Scene& scene, std::span<const Original> originals, int frames,
                                       gl::ContextPlatform platform);

  /// With triangles for the originals, a mesh each, and where `found` is not empty with what was recognised in them.
  core::Expected<MeanErrors> errors(std::span<const core::Mesh> meshes,
                                    std::span<const importers::RecognisedMesh> found) const;

 private:
  Images(const core::Scene& scene, std::span<const Original> originals, gl::ContextPlatform platform)
      : scene_(scene), originals_(originals), platform_(platform) {}
  core::Expected<std::vector<apps::DrawnImage>> draw(core::Scene& scene) const;

  const core::Scene& scene_;
  std::span<const Original> originals_;
  gl::ContextPlatform platform_;
  std::vector<core::View> views_;
  std::vector<apps::DrawnImage> reference_;
};

}  // namespace sightline::bench
