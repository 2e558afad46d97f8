#include "sightline/tests/support/simulated_gpu.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "sightline/core/internal/clock.h"

namespace sightline::tests {
namespace {

constexpr GLuint64 kForever = std::numeric_limits<GLuint64>::max();
constexpr double kTrianglesOfPoint = 8.0;  // that the geometry stage of a ray-cast item emits

/// The state of the one card that is simulated at a time.
struct State {
  CardModel model;
  gl::Functions real, simulated;
  SimulatedGpu::Account account;
  double now = 0.0, clock_step = 0.0;
  double gpu_free = 0.0;                             // when the work submitted so far ends
  std::map<GLsync, double> fences;                   // when the work before each ends
  std::map<GLuint, double> results;                  // the same by query
  std::map<std::pair<GLenum, GLuint>, GLuint> open;  // queries that have begun, by target and stream
  GLsizei last_points = 0;
  bool discards = false;  // what is drawn does not reach the rasteriser
  std::string renderer;
} state;

void work(double seconds) {
  state.gpu_free = std::max(state.now, state.gpu_free) + seconds;
  state.account.busy += seconds;
}

/// The CPU waits until then; the time is charged to `spent`.
void wait_until(double then, double& spent) {
  spent += std::max(0.0, then - state.now);
  state.now = std::max(state.now, then);
}

void wait_for_data(double bytes) {
  wait_until(std::max(state.now, state.gpu_free) + state.model.readback + bytes * state.model.byte,
             state.account.readbacks);
}

double tell_time() {
  return state.now += state.clock_step;
}

// --- draws ---

/// A command of glMultiDrawElementsIndirect.
struct ElementsCommand {
  GLuint count, instances, first;
  GLint base_vertex;
  GLuint base_instance;
};

double triangles_of(GLenum mode, double vertices) {
  if (mode == GL_TRIANGLES) return vertices / 3.0;
  return mode == GL_POINTS ? kTrianglesOfPoint * vertices : vertices;
}

void draws(double commands, double triangles) {
  state.account.draws += commands;
  state.account.triangles += triangles;
  work(commands * state.model.draw + triangles * state.model.triangle);
}

void points(double count) {
  work(state.model.draw + count * state.model.point);
}

void draw_commands(GLenum mode, const void* offset, std::size_t count, std::size_t stride) {
  GLint buffer = 0;
  state.real.GetIntegerv(GL_DRAW_INDIRECT_BUFFER_BINDING, &buffer);
  std::vector<unsigned char> bytes(count * stride);
  if (count == 0 || buffer == 0) return;
  state.real.GetNamedBufferSubData(GLuint(buffer), reinterpret_cast<GLintptr>(offset), GLsizeiptr(bytes.size()),
                                   bytes.data());
  double commands = 0.0, triangles = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    ElementsCommand command;
    std::copy_n(bytes.data() + i * stride, sizeof command, reinterpret_cast<unsigned char*>(&command));
    const double vertices = double(command.count) * command.instances;
    commands += vertices > 0.0;
    triangles += triangles_of(mode, vertices);
  }
  draws(commands, triangles);
}

void multi_draw(GLenum mode, GLenum type, const void* offset, GLsizei count, GLsizei stride) {
  draw_commands(mode, offset, std::size_t(count), std::size_t(stride));
  if (state.model.shows) state.real.MultiDrawElementsIndirect(mode, type, offset, count, stride);
}

void multi_draw_count(GLenum mode, GLenum type, const void* offset, GLintptr count_at, GLsizei most, GLsizei stride) {
  GLint buffer = 0;
  GLuint count = 0;
  state.real.GetIntegerv(GL_PARAMETER_BUFFER_BINDING_ARB, &buffer);
  state.real.GetNamedBufferSubData(GLuint(buffer), count_at, sizeof count, &count);
  draw_commands(mode, offset, std::min(std::size_t(count), std::size_t(most)), std::size_t(stride));
  if (state.model.shows) state.real.MultiDrawElementsIndirectCountARB(mode, type, offset, count_at, most, stride);
}

void draw_arrays(GLenum mode, GLint first, GLsizei count) {
  if (state.discards)
    points(state.last_points = count);
  else
    draws(1.0, triangles_of(mode, count));
  state.real.DrawArrays(mode, first, count);
}

/// How many points the feedback holds is not asked for: as many as were drawn to fill it.
void draw_feedback(GLenum mode, GLuint feedback, GLsizei instances) {
  points(double(state.last_points) * instances);
  state.real.DrawTransformFeedbackInstanced(mode, feedback, instances);
}

void dispatch(GLuint x, GLuint y, GLuint z) {
  work(state.model.draw + double(x) * y * z * state.model.work_group);
  state.real.DispatchCompute(x, y, z);
}

void enable(GLenum what) {
  if (what == GL_RASTERIZER_DISCARD) state.discards = true;
  state.real.Enable(what);
}
void disable(GLenum what) {
  if (what == GL_RASTERIZER_DISCARD) state.discards = false;
  state.real.Disable(what);
}

// --- fences and queries ---

GLsync fence_sync(GLenum condition, GLbitfield flags) {
  const GLsync fence = state.real.FenceSync(condition, flags);
  if (fence) state.fences[fence] = std::max(state.now, state.gpu_free);
  return fence;
}

void delete_sync(GLsync fence) {
  state.fences.erase(fence);
  state.real.DeleteSync(fence);
}

/// What the rasteriser has to do is done by the time that the card says so.
GLenum client_wait(GLsync fence, GLbitfield flags, GLuint64 timeout_ns) {
  const auto found = state.fences.find(fence);
  if (found == state.fences.end()) return state.real.ClientWaitSync(fence, flags, timeout_ns);
  const double known = found->second + state.model.notice, left = known - state.now;
  if (left > 1e-9 * double(timeout_ns)) {
    wait_until(state.now + 1e-9 * double(timeout_ns), state.account.fences);
    return GL_TIMEOUT_EXPIRED;
  }
  wait_until(known, state.account.fences);
  const GLenum done = state.real.ClientWaitSync(fence, flags, kForever);
  if (done == GL_WAIT_FAILED) return done;
  return left > 0.0 ? GL_CONDITION_SATISFIED : GL_ALREADY_SIGNALED;
}

void get_sync(GLsync fence, GLenum what, GLsizei size, GLsizei* length, GLint* value) {
  state.real.GetSynciv(fence, what, size, length, value);
  const auto found = state.fences.find(fence);
  if (what == GL_SYNC_STATUS && size > 0 && found != state.fences.end())
    *value = found->second + state.model.notice <= state.now ? GL_SIGNALED : GL_UNSIGNALED;
}

void finish() {
  state.real.Finish();
  wait_until(std::max(state.now, state.gpu_free) + state.model.notice, state.account.finishes);
}

void query_counter(GLuint query, GLenum target) {
  state.results[query] = std::max(state.now, state.gpu_free);
  state.real.QueryCounter(query, target);
}
void begin_query(GLenum target, GLuint stream, GLuint query) {
  state.open[{target, stream}] = query;
  state.real.BeginQueryIndexed(target, stream, query);
}
void end_query(GLenum target, GLuint stream) {
  state.results[state.open[{target, stream}]] = std::max(state.now, state.gpu_free);
  state.real.EndQueryIndexed(target, stream);
}

void get_query_facts(GLenum target, GLenum what, GLint* value) {
  state.real.GetQueryiv(target, what, value);
  if (target == GL_TIMESTAMP && what == GL_QUERY_COUNTER_BITS) *value = state.model.timers ? 64 : 0;
}
void get_integer64(GLenum what, GLint64* value) {
  state.real.GetInteger64v(what, value);
  if (what == GL_TIMESTAMP) *value = GLint64(1e9 * state.now);
}

bool is_timestamp(GLuint query) {
  GLint target = 0;
  state.real.GetQueryObjectiv(query, GL_QUERY_TARGET, &target);
  return target == GL_TIMESTAMP;
}

/// Results are waited for as far as `what` says so. False where there is none yet.
bool result_known(GLuint query, GLenum what) {
  const double known = state.results[query] + state.model.notice;
  if (what == GL_QUERY_RESULT) wait_until(known, state.account.readbacks);
  return known <= state.now;
}

template <class Value, class Get>
void get_query(GLuint query, GLenum what, Value* value, Get get) {
  const bool known = result_known(query, what);
  if (what == GL_QUERY_RESULT_AVAILABLE)
    *value = Value(known);
  else if (known && is_timestamp(query))
    *value = state.model.timers ? Value(1e9 * state.results[query]) : Value(1);
  else if (known)
    get(query, GL_QUERY_RESULT, value);
}
void get_query32(GLuint query, GLenum what, GLuint* value) {
  get_query(query, what, value, state.real.GetQueryObjectuiv);
}
void get_query64(GLuint query, GLenum what, GLuint64* value) {
  get_query(query, what, value, state.real.GetQueryObjectui64v);
}

// --- read-backs ---

void get_texture(GLuint texture, GLint level, GLenum format, GLenum type, GLsizei bytes, void* pixels) {
  state.real.GetTextureImage(texture, level, format, type, bytes, pixels);
  wait_for_data(bytes);
}
void get_buffer(GLuint buffer, GLintptr offset, GLsizeiptr bytes, void* data) {
  state.real.GetNamedBufferSubData(buffer, offset, bytes, data);
  wait_for_data(double(bytes));
}

const GLubyte* get_string(GLenum what) {
  return what == GL_RENDERER ? reinterpret_cast<const GLubyte*>(state.renderer.c_str()) : state.real.GetString(what);
}

/// What the card does in another way than the rasteriser.
gl::Functions simulated(const gl::Functions& real) {
  gl::Functions gl = real;
  gl.MultiDrawElementsIndirect = multi_draw;
  if (gl.MultiDrawElementsIndirectCountARB) gl.MultiDrawElementsIndirectCountARB = multi_draw_count;
  gl.DrawArrays = draw_arrays;
  gl.DrawTransformFeedbackInstanced = draw_feedback;
  gl.DispatchCompute = dispatch;
  gl.Enable = enable;
  gl.Disable = disable;
  gl.FenceSync = fence_sync;
  gl.DeleteSync = delete_sync;
  gl.ClientWaitSync = client_wait;
  gl.GetSynciv = get_sync;
  gl.Finish = finish;
  gl.QueryCounter = query_counter;
  gl.BeginQueryIndexed = begin_query;
  gl.EndQueryIndexed = end_query;
  gl.GetQueryiv = get_query_facts;
  gl.GetInteger64v = get_integer64;
  gl.GetQueryObjectuiv = get_query32;
  gl.GetQueryObjectui64v = get_query64;
  gl.GetTextureImage = get_texture;
  gl.GetNamedBufferSubData = get_buffer;
  gl.GetString = get_string;
  return gl;
}

/// Each call takes time of the CPU.
template <auto Member, class Result, class... Arguments>
auto timed(Result (*)(Arguments...)) -> Result (*)(Arguments...) {
  return [](Arguments... arguments) -> Result {
    state.now += state.model.call;
    return (state.simulated.*Member)(arguments...);
  };
}

}  // namespace

SimulatedGpu::SimulatedGpu(const gl::Context& context, CardModel model)
    : table_(const_cast<gl::Functions&>(context.functions())),
      capabilities_(const_cast<gl::Capabilities&>(context.capabilities())),
      software_(capabilities_.software),
      pinned_memory_(table_.pinned_memory) {
  state = State();
  state.real = table_;
  state.simulated = simulated(table_);
  state.model = std::move(model);
  // Results of the driver's self-test are remembered by this name.
  state.renderer =
      "simulated " + state.model.name + (state.model.timers ? "" : " without timers") + " over " + context.renderer();
#define SIGHTLINE_GL_FUNCTION(name, type) \
  if (table_.name) table_.name = timed<&gl::Functions::name>(table_.name);
#define SIGHTLINE_GL_EXTENSION(name, type, extension) SIGHTLINE_GL_FUNCTION(name, type)
#include "sightline/gl/function_table.inc"
  capabilities_.software = table_.pinned_memory = false;
  core::use_clock(tell_time);
}

SimulatedGpu::~SimulatedGpu() {
  core::use_clock(nullptr);
#define SIGHTLINE_GL_FUNCTION(name, type) table_.name = state.real.name;
#define SIGHTLINE_GL_EXTENSION(name, type, extension) SIGHTLINE_GL_FUNCTION(name, type)
#include "sightline/gl/function_table.inc"
  capabilities_.software = software_;
  table_.pinned_memory = pinned_memory_;
}

double SimulatedGpu::now() {
  return state.now;
}
void SimulatedGpu::cpu_works(double seconds) {
  state.now += seconds;
}
void SimulatedGpu::set_clock_step(double seconds) {
  state.clock_step = seconds;
}
const SimulatedGpu::Account& SimulatedGpu::account() {
  return state.account;
}

}  // namespace sightline::tests
