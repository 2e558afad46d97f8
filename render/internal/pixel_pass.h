// Draws that compute each pixel of a viewport from textures: one triangle over all of it.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "sightline/gl/external_target.h"
#include "sightline/gl/internal/program.h"
#include "sightline/gl/internal/vertex_array.h"

namespace sightline::render {

/// A fragment shader of such draws. Each of its switches, off or on, is one of two defines.
struct PixelShader {
  const char* file;
  std::array<std::array<const char*, 2>, 2> switches = {};  ///< null: no such switch
};
inline constexpr PixelShader kBackground{"background.frag"};
inline constexpr PixelShader kBlendResolve{"blend_resolve.frag"};
inline constexpr PixelShader kComposite{"composite.frag", {{{"IMAGE", "LAYER"}, {"WHOLE_PIXELS", "EACH_SAMPLE"}}}};
inline constexpr PixelShader kDepthShading{"depth_shading.frag"};
inline constexpr PixelShader kEnlarge{"enlarge.frag", {{{"IDS 0", "IDS 1"}}}};
inline constexpr PixelShader kOneSample{"one_sample.frag", {{{"IDS 0", "IDS 1"}, {"NORMALS 0", "NORMALS 1"}}}};
inline constexpr PixelShader kOutline{"outline.frag"};
inline constexpr PixelShader kPutEdges{"put_edges.frag"};
inline constexpr std::array kPixelShaders = {kBackground, kBlendResolve, kComposite, kDepthShading,
                                             kEnlarge,    kOneSample,    kOutline,   kPutEdges};

/// What such draws have in common. A draw is begin(), what it needs beyond that, and draw(). All calls set GL state and
/// leave it set.
class PixelPass {
 public:
  /// Uniforms that all fragment shaders for begin() have.
  enum Uniform : GLint { kCorner = 0, kLinearColour = 2 };

  explicit PixelPass(const gl::Functions& gl) : gl_(&gl) {}

  /// `made`, which is made first if it is empty: for textures of so many samples, and with these switches on. Fails
  /// with the driver's log.
  core::Expected<const gl::Program*> program(gl::Program& made, const PixelShader& shader, int samples,
                                             std::array<bool, 2> switches = {}) const;
  /// The programs of kPixelShaders.
  static std::vector<gl::PipelineDescription> all_programs();

  /// Makes draws write fragment output 0 to a part of a framebuffer, which is bound, without depth test and blending.
  void begin(const gl::Program& program, const gl::ExternalTarget& to) const;
  /// From begin() on: draws only what is nearer than what is there.
  void test_depth(const gl::ExternalTarget& to) const;
  /// From begin() on: blends colours that are multiplied by their alpha.
  void blend() const;

  /// Draws with the textures at units 0, 1 …, and leaves these units empty.
  void draw(const gl::Program& program, std::span<const GLuint> textures, GLenum texture_target) const;

 private:
  const gl::Functions* gl_;
  mutable gl::VertexArray no_attributes_;  // made with the first program
};

}  // namespace sightline::render
