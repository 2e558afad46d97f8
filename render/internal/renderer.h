// render: view + visible set -> image in a RenderTarget. Programs only for what a scene holds, one indirect
// multi-draw per batch. Knows nothing of cullers; render/image/ reads, writes and compares what it has drawn.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "sightline/core/internal/deadline.h"
#include "sightline/core/view.h"
#include "sightline/gl/internal/program.h"
#include "sightline/gl/internal/program_pipeline.h"
#include "sightline/gl/internal/vertex_array.h"
#include "sightline/gpuprims/surroundings.h"
#include "sightline/gpuscene/internal/draw_lists.h"
#include "sightline/render/internal/background_pass.h"
#include "sightline/render/internal/overlays.h"
#include "sightline/render/internal/render_target.h"
#include "sightline/render/internal/section_caps.h"

namespace sightline::render {

/// What surfaces become: pixels, pixels of a ghost, or sums of transparent surfaces of the scene's alpha (Overlays).
enum class Surface { kSolid, kGhost, kBlended };

/// What is drawn, and onto what. Borrows everything.
struct DrawPass {
  const core::View& view;
  const core::Snapshot& snapshot;
  const gpuscene::GpuScene& scene;
  const gpuscene::DrawLists& lists;
  const RenderTarget& target;  ///< the image, or for ghosts the layer
  Surface surface = Surface::kSolid;
  /// A table to use instead of the scene's, with as many rows as the scene has materials and one more
  /// (gpuprims::material_row); null: the scene's.
  const gl::TextureBuffer* materials = nullptr;
  const BlendedSums* sums = nullptr;  ///< gets blended surfaces
  glm::vec2 range{0.0f};              ///< eye depths between which blended surfaces lie
};

class Renderer {
 public:
  /// Compiles the programs of the batches that `scene` has and no others, for targets of one format. Fails with the
  /// driver's log. Programs for section planes are compiled with the first view that has some.
  static core::Expected<Renderer> create(const gl::Context& context, const gpuscene::GpuScene& scene,
                                         const TargetFormat& format = {});
  /// A renderer for any scene that has batches of these kinds alone.
  static core::Expected<Renderer> create(const gl::Context& context, std::span<const gpuscene::BatchKind> kinds,
                                         const TargetFormat& format);
  /// Creates a renderer in portions: begin(), and advance() until it returns true. Each call compiles at least one
  /// program, and ends after the one that is late.
  static core::Expected<Renderer> begin(const gl::Context& context);
  /// Whether the program cache has the program of a kind of batches in views without sections.
  static bool has_cached(const gl::Functions& gl, gpuscene::BatchKind kind, const TargetFormat& format);
  /// Programs are compiled for how a view cuts the scene.
  enum class Cut { kNone, kPlain, kHatched };
  static gl::ProgramDescription describe_batch(gpuscene::BatchKind kind, const TargetFormat& format, Cut cut,
                                               Surface surface);
  /// The programs of all kinds of batches, formats of targets, views and surfaces.
  static std::vector<gl::PipelineDescription> all_programs();
  core::Expected<bool> advance(const gpuscene::GpuScene& scene, const TargetFormat& format, core::Deadline deadline);
  /// Compiles the programs of kinds of batches that came into the scene since.
  core::Expected<void> follow(const gpuscene::GpuScene& scene, const TargetFormat& format);

  /// Makes the target show nothing but the background. Fails with the driver's log.
  core::Expected<void> clear(const RenderTarget& target);
  /// Draws the records in the lists beside what the target holds of the same view. Where two items have the same depth,
  /// the pixel keeps what it has. All analytic primitives are ray-cast and exact up to float arithmetic. With several
  /// samples per pixel, a primitive covers the samples whose rays hit it, with the colour and depth of one of them.
  /// Depth is reverse-Z whatever the view's own convention. Sets the GL state that it needs, except for what
  /// gl::reset_pipeline_state names, and leaves it set. Does not wait for the GPU. Programs of surfaces that are not
  /// solid are compiled when they are first used.
  core::Expected<void> draw(const DrawPass& pass);
  /// Clears the target first.
  core::Expected<void> draw(const core::View& view, const core::Snapshot& snapshot, const gpuscene::GpuScene& scene,
                            const gpuscene::DrawLists& lists, const RenderTarget& target) {
    auto done = clear(target);
    return done ? draw({view, snapshot, scene, lists, target}) : done;
  }

  gpuprims::Background background = {};
  gpuprims::Lighting lighting = gpuprims::Lighting::kHeadLight;
  core::dvec3 sun{0.0, 0.0, 1.0};  ///< as gpuprims::distant_lights() has it
  /// Lines on cut faces: their strength, 0 … 1, and their least distance in pixels; a sixth of that, or one pixel, is
  /// their width. 0: none.
  glm::vec2 hatching{0.0f, 6.0f};

  std::size_t memory_bytes() const;

 private:
  /// Program of a batch. A ray-cast batch has only the fragment stage, and a pipeline that joins it to the stages that
  /// all ray-cast batches share.
  struct BatchProgram {
    gl::Program program;
    gl::ProgramPipeline pipeline;
  };
  using BatchPrograms = std::array<BatchProgram, gpuscene::kBatchKindCount>;
  static constexpr std::size_t kSurfaces = 3;
  static constexpr std::size_t kCuts = 3;
  static gl::ShaderContext shader_context(const TargetFormat& format, Cut cut, Surface surface);
  /// Programs for a kind of surface, made when first used.
  struct SurfacePrograms {
    std::optional<BatchPrograms> plain, sections;
    std::optional<SectionCaps> caps;  // if there are meshes
    Cut cut = Cut::kPlain;            // what `sections` and `caps` are made for
  };

  core::Expected<void> upload_view(const core::View& view, const core::Snapshot& snapshot, const RenderTarget& target);
  core::Expected<const BatchPrograms*> programs_of(const DrawPass& pass);
  void draw_batch(const DrawPass& pass, const gpuscene::Batch& batch, const BatchProgram& program) const;
  void submit_batch(const DrawPass& pass, const gpuscene::Batch& batch, int first, int count) const;
  core::Expected<void> draw_section_caps(const DrawPass& pass, const gpuscene::Batch& meshes);
  core::Expected<void> make_programs(std::span<const gpuscene::BatchKind> kinds, const TargetFormat& format, Cut cut,
                                     Surface surface, BatchPrograms& made);

  const gl::Functions* gl_ = nullptr;
  gl::Program proxy_program_;  // the stages before the fragments' of all ray-cast batches; empty without such batches
  std::array<SurfacePrograms, kSurfaces> programs_;
  std::vector<gpuscene::BatchKind> kinds_;  // of the batches
  std::size_t compiled_ = 0;                // of these, whose first programs are made
  std::optional<BackgroundPass> background_pass_;
  gl::VertexArray record_array_, mesh_array_;
  gl::Buffer view_block_;
  gl::TexelArray chunk_rows_;
  std::vector<glm::vec4> origin_rows_;  // of the last view
};

}  // namespace sightline::render
