#include <array>
#include <atomic>
#include <utility>

#include <fmt/format.h>

#include "sightline/core/internal/platform/files.h"
#include "sightline/core/internal/platform/threads.h"
#include "sightline/gl/internal/current_context.h"
#include "sightline/gl/internal/dynamic_library.h"
#include "sightline/gl/internal/platform_context.h"

namespace sightline::gl {
namespace {

// From GL/osmesa.h, which a build need not have.
constexpr int kOsMesaFormat = 0x22;  // OSMESA_FORMAT
constexpr int kOsMesaProfile = 0x33, kOsMesaCoreProfile = 0x34;
constexpr int kOsMesaMajorVersion = 0x36, kOsMesaMinorVersion = 0x37;

/// The OSMesa entry points used here.
struct OsMesa {
  using Handle = struct osmesa_context*;
  Handle (*CreateContextAttribs)(const int* attributes, Handle shared) = nullptr;
  void (*DestroyContext)(Handle) = nullptr;
  GLboolean (*MakeCurrent)(Handle, void* buffer, GLenum type, GLsizei width, GLsizei height) = nullptr;
  Handle (*GetCurrentContext)() = nullptr;
  Proc (*GetProcAddress)(const char* name) = nullptr;
};

core::Expected<OsMesa> load_osmesa(const std::string& name) {
  constexpr const char* kOsMesaHint = "install libosmesa6";
  const auto opened = core::platform::open_module(core::platform::path_of(name));
  if (!opened) {
    const std::string& reason = opened.error().message;
    return core::fail(
        fmt::format("no OSMesa: {}; tried {} ({})", kOsMesaHint, name, reason.empty() ? "no reason given" : reason));
  }
  void* const library = *opened;
  OsMesa osmesa;
  const bool found = find_symbol(library, "OSMesaCreateContextAttribs", osmesa.CreateContextAttribs) &&
                     find_symbol(library, "OSMesaDestroyContext", osmesa.DestroyContext) &&
                     find_symbol(library, "OSMesaMakeCurrent", osmesa.MakeCurrent) &&
                     find_symbol(library, "OSMesaGetCurrentContext", osmesa.GetCurrentContext) &&
                     find_symbol(library, "OSMesaGetProcAddress", osmesa.GetProcAddress);
  if (found) return osmesa;
  return core::fail(fmt::format("OSMesa: {} lacks entry points of Mesa 12 or later; {}", name, kOsMesaHint));
}

/// A context with what OSMesa does not keep of it: on which thread it is current.
struct Body {
  Body(const OsMesa& entries, OsMesa::Handle made) : osmesa(entries), handle(made) {}
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;
  ~Body() { osmesa.DestroyContext(handle); }

  OsMesa osmesa;
  OsMesa::Handle handle;
  std::array<unsigned char, 4> pixel{};  // framebuffer 0, which OSMesa requires
  std::atomic<bool> current_somewhere = false;
  std::shared_ptr<Body> self;  // while it is current
};

thread_local Body* current_body = nullptr;
thread_local bool ends_watched = false;

/// Releases the context that is current when this thread ends.
void watch_end_of_thread() {
  if (!std::exchange(ends_watched, true))
    core::platform::at_end_of_thread([](void*) { release_osmesa_context_of_ours(); }, nullptr);
}

core::Expected<void> make_body_current(const std::shared_ptr<Body>& body) {
  const OsMesa& osmesa = body->osmesa;
  const bool ours = current_body == body.get();
  // OSMesa itself lets two threads have one context.
  if (!ours && body->current_somewhere.exchange(true))
    return core::fail("OSMesa: the context is current on another thread");
  if (!ours) release_osmesa_context_of_ours();
  release_other_contexts(ContextLibrary::kOsMesa);
  current_body = body.get();
  body->self = body;
  watch_end_of_thread();
  if (osmesa.MakeCurrent(body->handle, body->pixel.data(), GL_UNSIGNED_BYTE, 1, 1)) return {};
  release_osmesa_context_of_ours();
  return core::fail("OSMesaMakeCurrent failed");
}

class OsMesaContext final : public PlatformContext {
 public:
  explicit OsMesaContext(std::shared_ptr<Body> body) : body_(std::move(body)) {}
  OsMesaContext(const OsMesaContext&) = delete;
  OsMesaContext& operator=(const OsMesaContext&) = delete;
  ~OsMesaContext() override { OsMesaContext::release_current(); }

  core::Expected<void> make_current() const override {
    if (current_body == body_.get() && body_->osmesa.GetCurrentContext() == body_->handle) return {};
    return make_body_current(body_);
  }

  void release_current() const override {
    if (current_body == body_.get()) release_osmesa_context_of_ours();
  }

  Proc get_proc(const char* name) const override { return body_->osmesa.GetProcAddress(name); }
  std::string name() const override { return "OSMesa"; }

 private:
  std::shared_ptr<Body> body_;
};

}  // namespace

core::Expected<std::unique_ptr<PlatformContext>> create_osmesa_context(const ContextOptions& options) {
  auto osmesa = load_osmesa(options.osmesa_library);
  if (!osmesa) return tl::unexpected(osmesa.error());
  // No depth, stencil and accumulation buffers: nothing is drawn into framebuffer 0.
  const int attributes[] = {kOsMesaFormat,
                            GL_RGBA,
                            kOsMesaProfile,
                            kOsMesaCoreProfile,
                            kOsMesaMajorVersion,
                            kRequiredMajor,
                            kOsMesaMinorVersion,
                            kRequiredMinor,
                            0};
  const OsMesa::Handle handle = osmesa->CreateContextAttribs(attributes, nullptr);
  if (!handle)
    return core::fail(fmt::format("OSMesa: no OpenGL {}.{} core context; tried {}", kRequiredMajor, kRequiredMinor,
                                  options.osmesa_library));
  auto context = std::make_unique<OsMesaContext>(std::make_shared<Body>(*osmesa, handle));
  if (auto current = context->make_current(); !current) return tl::unexpected(current.error());
  return context;
}

std::shared_ptr<void> osmesa_context_of_ours() {
  const bool current = current_body && current_body->osmesa.GetCurrentContext() == current_body->handle;
  return current ? current_body->self : nullptr;
}

void release_osmesa_context_of_ours() {
  if (!current_body) return;
  const std::shared_ptr<Body> body = std::move(current_body->self);
  current_body = nullptr;
  if (body->osmesa.GetCurrentContext() == body->handle) body->osmesa.MakeCurrent(nullptr, nullptr, 0, 0, 0);
  body->current_somewhere = false;
}

void make_current_again(const std::shared_ptr<void>& context) {
  const auto body = std::static_pointer_cast<Body>(context);
  const bool destroyed = body.use_count() == 2;  // the caller's and this one are all that is left
  if (!destroyed) (void)make_body_current(body);
}

}  // namespace sightline::gl
