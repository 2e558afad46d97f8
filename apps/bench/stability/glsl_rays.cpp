#include "sightline/apps/bench/stability/glsl_rays.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "sightline/apps/bench/stability/shaders.h"
#include "sightline/gl/internal/buffer.h"
#include "sightline/gpuprims/internal/packing.h"
#include "sightline/gpuprims/internal/shaders.h"
#include "sightline/gpuscene/internal/batch_kinds.h"

namespace sightline::bench {
namespace {

using core::dmat3;
using core::dvec3;
using core::Kind;
using gpuprims::Texel;

constexpr GLint kCountUniform = 0;
constexpr float kNoHit = 3.0e38f;

/// The frame that a record holds, read back in the shader's way.
core::Affine chunk_from_local(std::span<const Texel> record) {
  double v[12];
  for (std::size_t i = 0; i < 12; ++i) v[i] = double(std::bit_cast<float>(record[i / 4][i % 4]));
  return {dmat3(v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], v[8]), {v[9], v[10], v[11]}};
}

struct LocalRay {
  glm::vec4 origin, direction;
};
struct ShaderCrossing {
  glm::vec3 normal;
  float t;
};

/// The shader's input for a sample, and data to interpret its answer.
struct Prepared {
  bool shown = false;  ///< see primitive.vert
  LocalRay ray;
  double start = 0.0;  ///< t of the moved origin
  dmat3 item_normal_from_local{0.0};
};

/// The axis along which needles are shifted, in the record's units. Only for kinds whose shaders expect that.
struct Axis {
  bool shifts = false;
  double half_height = 0.0;
  glm::dvec2 lean{0.0};

  dvec3 at(double z) const { return {lean * z, z}; }
};
Axis axis_of(const core::Primitive& primitive) {
  const auto axis = [](double height, double unit, double offset_x, double offset_y) {
    const glm::dvec2 lean = height > 0.0 ? glm::dvec2(offset_x, offset_y) / height : glm::dvec2(0.0);
    return Axis{unit > 0.0, 0.5 * height / unit, lean};
  };
  const auto size = [](float v) { return std::fabs(double(v)); };
  if (const auto* c = std::get_if<core::Cylinder>(&primitive)) return axis(size(c->height), size(c->radius), 0.0, 0.0);
  if (const auto* s = std::get_if<core::Snout>(&primitive))
    return axis(size(s->height), std::max(size(s->bottom_radius), size(s->top_radius)), s->offset_x, s->offset_y);
  if (const auto* t = std::get_if<core::RectangularTorus>(&primitive))
    return axis(size(t->height), std::max(size(t->inner_radius), size(t->outer_radius)), 0.0, 0.0);
  if (const auto* p = std::get_if<core::Pyramid>(&primitive))
    return axis(size(p->height),
                std::max({size(p->bottom_x), size(p->bottom_y), size(p->top_x), size(p->top_y), size(p->height)}),
                p->offset_x, p->offset_y);
  return {};
}

/// z of the point on the axis nearest to the line.
double nearest_on_axis(const Axis& axis, const dvec3& o, const dvec3& d) {
  const dvec3 along = axis.at(1.0), normal = glm::cross(along, d), side = glm::cross(d, normal);
  const double speed = glm::dot(along, side);
  if (!(std::fabs(speed) > 0.0)) return 0.0;
  return std::clamp(glm::dot(o, side) / speed, -axis.half_height, axis.half_height);
}

Prepared prepare(const Sample& sample, std::span<const Texel> record) {
  // The item's frame is its chunk, so only its size and its ray are rounded.
  const core::Affine local_frame = chunk_from_local(record);
  const dmat3 local_from_world = glm::inverse(local_frame.linear);
  const dvec3 d = local_from_world * sample.ray.direction;
  dvec3 o = local_from_world * ((sample.ray.origin - sample.world_from_item.origin) - local_frame.origin);
  const Axis axis = axis_of(sample.primitive);
  Prepared prepared;
  const core::mat3 linear(local_frame.linear);
  const float volume = std::fabs(glm::dot(linear[0], glm::cross(linear[1], linear[2])));
  prepared.shown = volume > 0.0f && volume < kNoHit;
  prepared.start = -glm::dot(o, d) / glm::dot(d, d);
  o += prepared.start * d;
  float shift = 0.0f;
  if (axis.shifts) {
    shift = float(nearest_on_axis(axis, o, d));
    o -= axis.at(double(shift));
    const double step = -glm::dot(o, d) / glm::dot(d, d);
    prepared.start += step;
    o += step * d;
  }
  prepared.ray = {glm::vec4(glm::vec3(o), shift), glm::vec4(glm::vec3(d), 0.0f)};
  prepared.item_normal_from_local = glm::transpose(sample.world_from_item.linear) * glm::transpose(local_from_world);
  return prepared;
}

Answer answer_of(const Prepared& prepared, const ShaderCrossing& found) {
  Answer answer;
  answer.first_only = true;
  if (found.t == kNoHit || !prepared.shown) return answer;
  const dvec3 normal(found.normal);
  const dvec3 turned = prepared.item_normal_from_local * normal;
  // A singular frame has no normals; the test is then only whether the shader's own normal is finite.
  answer.hits.insert({prepared.start + double(found.t), core::is_finite(turned) ? turned : normal, 0});
  return answer;
}

gl::ProgramDescription describe_rays(gpuscene::BatchKind batch) {
  gl::ProgramDescription description;
  description.name = "rays at " + std::string(gpuscene::name_of(batch));
  description.stages = {{GL_COMPUTE_SHADER, {"rays.comp"}}};
  description.shaders.tables = {shaders(), gpuprims::shaders()};
  description.shaders.defines = gpuscene::batch_defines(batch);
  return description;
}

}  // namespace

std::vector<gl::PipelineDescription> GlslRays::all_programs() {
  std::vector<gl::PipelineDescription> all;
  for (int batch = 0; batch < gpuscene::kBatchKindCount; ++batch)
    if (gpuscene::is_ray_cast(gpuscene::BatchKind(batch))) all.push_back({describe_rays(gpuscene::BatchKind(batch))});
  return all;
}

core::Expected<GlslRays> GlslRays::create(gl::ContextPlatform platform) {
  auto context = gl::Context::create_offscreen({.platform = platform});
  if (!context) return tl::unexpected(context.error());
  return GlslRays(std::move(*context));
}

core::Expected<const gl::Program*> GlslRays::program(Kind kind) {
  const gpuscene::BatchKind batch = gpuscene::batch_of(kind);
  const std::string name(gpuscene::name_of(batch));
  const auto known = programs_.find(name);
  if (known != programs_.end()) return &known->second;
  auto made = gl::Program::create(context_.functions(), describe_rays(batch));
  if (!made) return tl::unexpected(made.error());
  return &programs_.emplace(name, std::move(*made)).first->second;
}

core::Expected<std::vector<Answer>> GlslRays::trace(Kind kind, std::span<const Sample> samples) {
  const auto used = program(kind);
  if (!used) return tl::unexpected(used.error());

  const std::size_t texels = std::size_t(gpuprims::texels_per_item(kind));
  std::vector<Texel> records(samples.size() * texels);
  std::vector<Prepared> prepared;
  std::vector<LocalRay> rays;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Sample& sample = samples[i];
    const std::span<Texel> record(records.data() + i * texels, texels);
    gpuprims::PackedItem item;
    item.placement.linear = core::mat3(sample.world_from_item.linear);
    gpuprims::pack(kind, core::parameters(sample.primitive), item, record);
    prepared.push_back(prepare(sample, record));
    rays.push_back(prepared.back().ray);
  }

  const gl::Functions& gl = context_.functions();
  auto record_buffer = gl::Buffer::create(gl, std::span(records), 0, "records");
  if (!record_buffer) return tl::unexpected(record_buffer.error());
  auto record_texels = gl::TextureBuffer::create(gl, *record_buffer, GL_RGBA32UI, "records");
  if (!record_texels) return tl::unexpected(record_texels.error());
  auto ray_buffer = gl::Buffer::create(gl, std::span(rays), 0, "rays");
  if (!ray_buffer) return tl::unexpected(ray_buffer.error());
  std::vector<ShaderCrossing> found(samples.size());
  auto found_buffer = gl::Buffer::create(gl, std::span(found), 0, "crossings");
  if (!found_buffer) return tl::unexpected(found_buffer.error());

  constexpr GLuint kGroup = 64;
  const GLuint count = GLuint(samples.size());
  (*used)->use();
  gl.ProgramUniform1ui((*used)->id(), kCountUniform, count);
  gl.BindTextureUnit(0, record_texels->id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, ray_buffer->id());
  gl.BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, found_buffer->id());
  gl.DispatchCompute((count + kGroup - 1) / kGroup, 1, 1);
  gl.MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  found_buffer->read(0, found_buffer->size(), found.data());

  std::vector<Answer> answers;
  answers.reserve(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) answers.push_back(answer_of(prepared[i], found[i]));
  return answers;
}

}  // namespace sightline::bench
