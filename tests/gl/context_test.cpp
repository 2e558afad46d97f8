#include "sightline/gl/context.h"

#include <cstring>
#include <future>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/gl/internal/buffer.h"
#include "sightline/tests/support/environment.h"
#include "sightline/tests/support/gl_test.h"
#include "sightline/tests/support/system_gl.h"

namespace sightline::gl::context_test {
namespace {

using ContextTest = tests::GlTest;
constexpr bool kHasEgl = tests::kHasOsMesa;

/// An application's own way to find functions of a context, with some names held back.
struct ForeignLoader {
  explicit ForeignLoader(const Context& context)
      : library(context.platform().starts_with("OSMesa") ? tests::kOsMesaLibrary : tests::kSystemLibrary) {}
  tests::GlLibrary library;
  const char* hidden = "";
  const char* also_hidden = "";
};

Proc foreign_get_proc(const char* name, void* user) {
  const auto* loader = static_cast<const ForeignLoader*>(user);
  if (std::strcmp(name, loader->hidden) == 0 || std::strcmp(name, loader->also_hidden) == 0) return nullptr;
  return tests::foreign_proc(loader->library, name);
}

Context make_context(ContextPlatform platform) {
  ContextOptions options;
  options.platform = platform;
  options.debug = true;
  auto made = Context::create_offscreen(options);
  EXPECT_TRUE(made) << made.error().message;
  return std::move(*made);
}

GLuint make_buffer_of(const Context& context, std::uint32_t value, Buffer& buffer) {
  auto made = Buffer::create(context.functions(), sizeof value, &value, 0, "one value");
  EXPECT_TRUE(made) << made.error().message;
  buffer = std::move(*made);
  return buffer.id();
}

std::uint32_t value_in(const Buffer& buffer) {
  std::uint32_t value = 0;
  buffer.read(0, sizeof value, &value);
  return value;
}

/// Once a driver has told of a reset the context stays lost, also when the driver is through with it.
TEST_F(ContextTest, ALostContextStaysLost) {
  EXPECT_FALSE(context->lost());
  auto& gl = const_cast<Functions&>(context->functions());
  auto& told = const_cast<Capabilities&>(context->capabilities()).reset_notification;
  gl.GetGraphicsResetStatus = []() -> GLenum { return GL_INNOCENT_CONTEXT_RESET; };
  told = false;
  EXPECT_FALSE(context->lost()) << "a context that was not asked to tell has nothing to say";
  told = true;
  EXPECT_TRUE(context->lost());
  gl.GetGraphicsResetStatus = []() -> GLenum { return GL_NO_ERROR; };
  EXPECT_TRUE(context->lost());
}

TEST_F(ContextTest, AutomaticContextIsUsable) {
  EXPECT_FALSE(context->renderer().empty());
  EXPECT_FALSE(context->vendor().empty());
  EXPECT_FALSE(context->version().empty());
  EXPECT_TRUE(context->platform().starts_with("EGL ") || context->platform() == "WGL" ||
              context->platform().starts_with("OSMesa"))
      << context->platform();
  GLint profile = 0;
  gl().GetIntegerv(GL_CONTEXT_PROFILE_MASK, &profile);
  EXPECT_EQ(profile, GL_CONTEXT_CORE_PROFILE_BIT);
  RecordProperty("renderer", context->renderer());
}

TEST_F(ContextTest, CapabilitiesMeetWhatGlGuarantees) {
  const Capabilities& caps = context->capabilities();
  EXPECT_GE(caps.max_texture_buffer_texels, 65536);
  EXPECT_GE(caps.max_storage_block_bytes, 1 << 24);
  EXPECT_GE(caps.max_uniform_block_bytes, 16384);
  EXPECT_GE(caps.max_geometry_output_vertices, 256);
  EXPECT_GE(caps.max_geometry_output_components, 1024);
  EXPECT_GE(caps.max_clip_distances, 8);
  EXPECT_GE(caps.max_texture_size, 16384);
  EXPECT_GE(caps.max_samples, 4);
  EXPECT_GT(caps.uniform_offset_alignment, 0);
  EXPECT_EQ(caps.software, context->renderer().find("llvmpipe") != std::string::npos) << context->renderer();
  EXPECT_EQ(caps.indirect_count, gl().MultiDrawElementsIndirectCountARB != nullptr);
}

TEST_F(ContextTest, EachPlatformEitherWorksOrSaysWhyNot) {
  const std::pair<ContextPlatform, const char*> expected[] = {{ContextPlatform::kEgl, "EGL "},
                                                              {ContextPlatform::kEglSurfaceless, "EGL surfaceless"},
                                                              {ContextPlatform::kEglDevice, "EGL device"},
                                                              {ContextPlatform::kWgl, "WGL"},
                                                              {ContextPlatform::kOsMesa, "OSMesa"}};
  for (const auto& [platform, name] : expected) {
    ContextOptions options;
    options.platform = platform;
    auto made = Context::create_offscreen(options);
    if (!made) {
      const bool of_this_system = (platform == ContextPlatform::kWgl) != kHasEgl;
      EXPECT_NE(made.error().message.find(of_this_system ? "tried" : "no "), std::string::npos) << made.error().message;
      continue;
    }
    EXPECT_EQ(made->platform().rfind(name, 0), 0u) << made->platform();
    EXPECT_TRUE(made->take_errors().empty());
  }
  ASSERT_TRUE(context->make_current());
}

TEST_F(ContextTest, AbsentDeviceIsAnError) {
  if (!kHasEgl) GTEST_SKIP() << "no EGL here";
  ContextOptions options;
  options.platform = ContextPlatform::kEglDevice;
  options.device = 1000;
  const auto made = Context::create_offscreen(options);
  ASSERT_FALSE(made);
  EXPECT_NE(made.error().message.find("tried none"), std::string::npos) << made.error().message;
}

constexpr const char* kNoSuchLibrary = "libnowhere.so.1";

TEST(ContextWithoutLibrary, MissingLibraryIsAnErrorThatSaysWhatToInstall) {
  if (!kHasEgl) GTEST_SKIP() << "libraries are part of the system here";
  ContextOptions options;
  options.egl_library = options.osmesa_library = kNoSuchLibrary;
  const std::pair<ContextPlatform, const char*> expected[] = {
      {ContextPlatform::kEgl, "no EGL: install libegl1"}, {ContextPlatform::kOsMesa, "no OSMesa: install libosmesa6"}};
  for (const auto& [platform, hint] : expected) {
    options.platform = platform;
    const auto made = Context::create_offscreen(options);
    ASSERT_FALSE(made);
    const std::string& message = made.error().message;
    EXPECT_EQ(message.rfind(hint, 0), 0u) << message;
    EXPECT_NE(message.find(kNoSuchLibrary), std::string::npos) << message;
  }
}

TEST(ContextWithoutLibrary, AnotherLibraryIsAnError) {
  if (!kHasEgl) GTEST_SKIP() << "libraries are part of the system here";
  ContextOptions options;
  options.egl_library = options.osmesa_library = "libm.so.6";
  for (const ContextPlatform platform : {ContextPlatform::kEgl, ContextPlatform::kOsMesa}) {
    options.platform = platform;
    const auto made = Context::create_offscreen(options);
    ASSERT_FALSE(made);
    EXPECT_NE(made.error().message.find("libm.so.6"), std::string::npos) << made.error().message;
  }
}

TEST(ContextPlatformNames, AreThoseThatAreParsed) {
  for (int i = 0; i <= int(ContextPlatform::kWgl); ++i)
    EXPECT_EQ(parse_platform(std::string(name_of(ContextPlatform(i)))).value(), ContextPlatform(i));
  const auto other = parse_platform("glx");
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().message,
            "expected one of auto, egl, egl-surfaceless, egl-device, osmesa, wgl, found \"glx\"");
}

/// What the automatic platform does is up to the environment: these tests set it.
class AutomaticPlatform : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!kHasEgl) GTEST_SKIP() << "no OSMesa here";
    ContextOptions osmesa;
    osmesa.platform = ContextPlatform::kOsMesa;
    const auto made = Context::create_offscreen(osmesa);
    if (made) return;
    if (!tests::may_skip(made.error().message)) FAIL() << made.error().message;
    GTEST_SKIP() << made.error().message;
  }
  ContextOptions options;
  const tests::Variable platform{"SIGHTLINE_CONTEXT"};
};

TEST_F(AutomaticPlatform, FallsBackToOsMesaWithoutEgl) {
  platform.set(std::nullopt);
  options.egl_library = kNoSuchLibrary;
  const auto made = Context::create_offscreen(options);
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_EQ(made->platform().rfind("OSMesa (no EGL: ", 0), 0u) << made->platform();
  options.osmesa_library = kNoSuchLibrary;
  const auto neither = Context::create_offscreen(options);
  ASSERT_FALSE(neither);
  EXPECT_NE(neither.error().message.find("libegl1"), std::string::npos) << neither.error().message;
  EXPECT_NE(neither.error().message.find("libosmesa6"), std::string::npos) << neither.error().message;
}

TEST_F(AutomaticPlatform, IsChosenByTheEnvironment) {
  platform.set("osmesa");
  const auto made = Context::create_offscreen(options);
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_EQ(made->platform(), "OSMesa");
  platform.set("egl");
  options.egl_library = kNoSuchLibrary;
  EXPECT_FALSE(Context::create_offscreen(options)) << "another platform than the one that is asked for";
  options.platform = ContextPlatform::kOsMesa;
  EXPECT_TRUE(Context::create_offscreen(options)) << "the program's own choice counts more";
  platform.set("glx");
  const auto unknown = Context::create_offscreen();
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().message.rfind("SIGHTLINE_CONTEXT: expected one of auto,", 0), 0u)
      << unknown.error().message;
}

TEST_F(ContextTest, AdoptsAForeignContext) {
  ForeignLoader loader(*context);
  auto adopted = Context::adopt(&foreign_get_proc, &loader);
  ASSERT_TRUE(adopted) << adopted.error().message;
  EXPECT_EQ(adopted->platform(), "adopted");
  EXPECT_EQ(adopted->renderer(), context->renderer());
  {
    Buffer buffer;
    make_buffer_of(*adopted, 42, buffer);
    EXPECT_EQ(value_in(buffer), 42u);
  }
  EXPECT_TRUE(adopted->make_current());
  adopted->release_current();
  adopted = core::fail("dropped");
  // The application's context is as it was.
  GLint major = 0;
  gl().GetIntegerv(GL_MAJOR_VERSION, &major);
  EXPECT_EQ(major, 4);
}

TEST_F(ContextTest, AdoptingWithoutAContextIsAnError) {
  context->release_current();
  ForeignLoader loader(*context);
  const auto adopted = Context::adopt(&foreign_get_proc, &loader);
  ASSERT_FALSE(adopted);
  EXPECT_NE(adopted.error().message.find("no context is current"), std::string::npos) << adopted.error().message;
  ASSERT_TRUE(context->make_current());
}

TEST_F(ContextTest, MissingFunctionsAreAllNamed) {
  ForeignLoader loader(*context);
  loader.hidden = "glMultiDrawElementsIndirect";
  loader.also_hidden = "glClipControl";
  const auto functions = load_functions(&foreign_get_proc, &loader);
  ASSERT_FALSE(functions);
  const std::string& message = functions.error().message;
  EXPECT_NE(message.find("glMultiDrawElementsIndirect"), std::string::npos) << message;
  EXPECT_NE(message.find("glClipControl"), std::string::npos) << message;
  EXPECT_NE(message.find("required 4.5"), std::string::npos) << message;
  EXPECT_EQ(message.find("glEnable"), std::string::npos) << message;
}

TEST_F(ContextTest, MissingBasicFunctionIsNamed) {
  ForeignLoader loader(*context);
  loader.hidden = "glGetString";
  const auto functions = load_functions(&foreign_get_proc, &loader);
  ASSERT_FALSE(functions);
  EXPECT_NE(functions.error().message.find("glGetString"), std::string::npos) << functions.error().message;
}

TEST_F(ContextTest, MissingExtensionFunctionIsNull) {
  ForeignLoader loader(*context);
  loader.hidden = "glMultiDrawElementsIndirectCountARB";
  auto adopted = Context::adopt(&foreign_get_proc, &loader);
  ASSERT_TRUE(adopted) << adopted.error().message;
  EXPECT_EQ(adopted->functions().MultiDrawElementsIndirectCountARB, nullptr);
  EXPECT_FALSE(adopted->capabilities().indirect_count);
}

PFNGLGETSTRINGIPROC real_get_stringi = nullptr;
const GLubyte* APIENTRY hide_indirect_parameters(GLenum name, GLuint index) {
  const GLubyte* text = real_get_stringi(name, index);
  const bool hidden = std::strcmp(reinterpret_cast<const char*>(text), "GL_ARB_indirect_parameters") == 0;
  return hidden ? reinterpret_cast<const GLubyte*>("GL_hidden") : text;
}
Proc get_proc_without_extension(const char* name, void* user) {
  if (std::strcmp(name, "glGetStringi") == 0) return reinterpret_cast<Proc>(&hide_indirect_parameters);
  return foreign_get_proc(name, user);
}

/// Platforms find functions of extensions that the context does not have.
TEST_F(ContextTest, FunctionsOfUnlistedExtensionsAreNull) {
  ForeignLoader loader(*context);
  real_get_stringi = gl().GetStringi;
  const auto functions = load_functions(&get_proc_without_extension, &loader);
  ASSERT_TRUE(functions) << functions.error().message;
  EXPECT_EQ(functions->MultiDrawElementsIndirectCountARB, nullptr);
  EXPECT_EQ(functions->MultiDrawArraysIndirectCountARB, nullptr);
}

TEST_F(ContextTest, NothingIsCurrentAfterTheCurrentOneEnds) {
  { const Context other = make_context(ContextPlatform::kAutomatic); }
  ForeignLoader loader(*context);
  EXPECT_FALSE(load_functions(&foreign_get_proc, &loader));
  ASSERT_TRUE(context->make_current());
}

const GLubyte* APIENTRY old_get_string(GLenum) {
  return reinterpret_cast<const GLubyte*>("3.3 (Core Profile) Fake");
}
void APIENTRY old_get_integer(GLenum name, GLint* value) {
  *value = name == GL_NUM_EXTENSIONS ? 0 : 3;
}
Proc old_get_proc(const char* name, void*) {
  if (std::strcmp(name, "glGetString") == 0) return reinterpret_cast<Proc>(&old_get_string);
  return reinterpret_cast<Proc>(&old_get_integer);
}

TEST(LoadFunctions, OldVersionIsAnErrorThatSaysBothVersions) {
  const auto functions = load_functions(&old_get_proc, nullptr);
  ASSERT_FALSE(functions);
  EXPECT_EQ(functions.error().message, "OpenGL: found version 3.3 (Core Profile) Fake, required 4.5 core");
}

TEST_F(ContextTest, DebugErrorsAreCollectedAndTaken) {
  gl().Enable(0xdead);
  const auto errors = context->take_errors();
  ASSERT_EQ(errors.size(), 2u);
  EXPECT_NE(errors[0].find("GL_INVALID_ENUM"), std::string::npos) << errors[0];
  EXPECT_EQ(errors[1], "GetError: GL_INVALID_ENUM");
  EXPECT_TRUE(context->take_errors().empty());
}

TEST_F(ContextTest, DebugLogIsBounded) {
  for (std::size_t i = 0; i < DebugLog::kCapacity + 10; ++i) gl().Enable(0xdead);
  EXPECT_EQ(context->debug_log().messages().size(), DebugLog::kCapacity);
  EXPECT_EQ(context->debug_log().dropped(), 10u);
  const auto errors = context->take_errors();
  ASSERT_EQ(errors.size(), DebugLog::kCapacity + 2);
  EXPECT_EQ(errors[DebugLog::kCapacity], "10 further GL errors were not kept");
  EXPECT_TRUE(context->debug_log().messages().empty());
}

TEST_F(ContextTest, WithoutDebugGetErrorIsStillAsked) {
  auto plain = Context::create_offscreen();
  ASSERT_TRUE(plain) << plain.error().message;
  plain->functions().Enable(0xdead);
  EXPECT_EQ(plain->take_errors(), std::vector<std::string>{"GetError: GL_INVALID_ENUM"});
  plain = core::fail("dropped");
  ASSERT_TRUE(context->make_current());
}

TEST_F(ContextTest, TwoContextsAreIndependent) {
  Buffer here;
  make_buffer_of(*context, 1, here);
  {
    Context other = make_context(ContextPlatform::kAutomatic);
    Buffer there;
    make_buffer_of(other, 2, there);
    ASSERT_TRUE(context->make_current());
    EXPECT_EQ(value_in(here), 1u);
    gl().Enable(0xdead);
    ASSERT_TRUE(other.make_current());
    EXPECT_EQ(value_in(there), 2u);
    EXPECT_TRUE(other.take_errors().empty());
  }
  // The other one's end leaves this one alive.
  ASSERT_TRUE(context->make_current());
  EXPECT_EQ(context->take_errors().size(), 2u);
  EXPECT_EQ(value_in(here), 1u);
}

/// Mesa keeps one current context for EGL and OSMesa together, and neither is told what the other does.
TEST_F(ContextTest, EglAndOsMesaTakeTurns) {
  if (!kHasEgl) GTEST_SKIP() << "no EGL here";
  const ContextPlatform platforms[] = {ContextPlatform::kEgl, ContextPlatform::kOsMesa, ContextPlatform::kOsMesa};
  std::vector<Context> contexts;
  std::vector<Buffer> buffers(std::size(platforms));
  ContextOptions options;
  options.debug = true;
  for (const ContextPlatform platform : platforms) {
    options.platform = platform;
    auto made = Context::create_offscreen(options);
    if (!made && tests::may_skip(made.error().message)) GTEST_SKIP() << made.error().message;
    ASSERT_TRUE(made) << made.error().message;
    contexts.push_back(std::move(*made));
    make_buffer_of(contexts.back(), std::uint32_t(contexts.size()), buffers[contexts.size() - 1]);
  }
  const auto use = [&](std::size_t i) {
    ASSERT_TRUE(contexts[i].make_current());
    EXPECT_EQ(value_in(buffers[i]), i + 1);
    EXPECT_TRUE(contexts[i].take_errors().empty());
  };
  for (const std::size_t i : {0, 1, 0, 2, 1, 2, 0, 0, 2}) use(i);
  // What another platform's context replaced is free for other threads.
  use(0);
  std::thread([&] {
    use(2);
    contexts[2].release_current();
  }).join();
  const ForeignLoader of_egl(contexts[0]), of_osmesa(contexts[1]);
  contexts[0].release_current();  // is not the current one
  use(2);
  contexts[2].release_current();
  EXPECT_FALSE(load_functions(&foreign_get_proc, const_cast<ForeignLoader*>(&of_egl)));
  EXPECT_FALSE(load_functions(&foreign_get_proc, const_cast<ForeignLoader*>(&of_osmesa)));
  // Each end leaves the others alive, from whichever is current.
  use(0);
  ASSERT_TRUE(contexts[1].make_current());
  buffers[1] = {};
  contexts.erase(contexts.begin() + 1);
  buffers.erase(buffers.begin() + 1);
  ASSERT_TRUE(contexts[1].make_current());
  EXPECT_EQ(value_in(buffers[1]), 3u);
  ASSERT_TRUE(contexts[0].make_current());
  EXPECT_EQ(value_in(buffers[0]), 1u);
  buffers[0] = {};
  ASSERT_TRUE(contexts[1].make_current());
  buffers.clear();
  contexts.clear();
  ASSERT_TRUE(context->make_current());
}

/// What is left of a context that went first frees nothing, least of all what another context calls by the same name.
TEST_F(ContextTest, AShareOutlivesItsContext) {
  for (const bool assigned : {false, true}) {
    Context first = make_context(ContextPlatform::kAutomatic);
    const Context share = first.share();
    Buffer of_first, of_second;
    make_buffer_of(share, 1, of_first);
    EXPECT_FALSE(share.lost());
    { const Context another = share.share(); }
    EXPECT_TRUE(share.make_current() && !share.lost()) << "shares come and go";
    Context second = make_context(ContextPlatform::kAutomatic);
    ASSERT_EQ(make_buffer_of(second, 2, of_second), of_first.id()) << "the same name";
    if (assigned)
      first = std::move(second);
    else
      Context(std::move(first));
    EXPECT_TRUE(share.lost());
    const auto current = share.make_current();
    ASSERT_FALSE(current);
    EXPECT_NE(current.error().message.find("destroyed"), std::string::npos) << current.error().message;
    EXPECT_EQ(share.renderer(), context->renderer()) << "what is known stays";
    of_first = {};
    EXPECT_EQ(value_in(of_second), 2u);
    of_second = {};
  }
  ASSERT_TRUE(context->make_current());
}

TEST_F(ContextTest, MovingKeepsTheTableAndTheLog) {
  const Functions* table = &gl();
  Context moved = std::move(*context);
  EXPECT_EQ(&moved.functions(), table);
  moved.functions().Enable(0xdead);
  EXPECT_EQ(moved.take_errors().size(), 2u);
  *context = std::move(moved);
  EXPECT_EQ(&gl(), table);
}

TEST_F(ContextTest, AnotherThreadMayTakeIt) {
  context->release_current();
  bool taken = false;
  std::uint32_t value = 0;
  std::thread worker([&] {
    taken = context->make_current().has_value();
    Buffer buffer;
    make_buffer_of(*context, 7, buffer);
    value = value_in(buffer);
    buffer = Buffer();
    context->release_current();
  });
  worker.join();
  EXPECT_TRUE(taken);
  EXPECT_EQ(value, 7u);
  ASSERT_TRUE(context->make_current());
}

TEST_F(ContextTest, CurrentElsewhereIsAnError) {
  std::thread([&] {
    const auto taken = context->make_current();
    ASSERT_FALSE(taken);
    EXPECT_FALSE(taken.error().message.empty());
  }).join();
  EXPECT_TRUE(context->make_current());
}

/// A context may end on another thread than the one it is current on, which does not know of it.
TEST_F(ContextTest, MayEndWhileCurrentOnAnotherThread) {
  for (const bool thread_ends : {false, true}) {
    if (thread_ends && !context->platform().starts_with("OSMesa"))
      continue;  // EGL keeps a context that a thread ends with
    std::optional<Context> other;
    std::promise<void> made, ended;
    std::thread worker([&] {
      other.emplace(make_context(ContextPlatform::kAutomatic));
      made.set_value();
      ended.get_future().wait();
      if (thread_ends) return;
      const Context next = make_context(ContextPlatform::kAutomatic);
      Buffer buffer;
      make_buffer_of(next, 7, buffer);
      EXPECT_EQ(value_in(buffer), 7u);
    });
    made.get_future().wait();
    other.reset();
    ended.set_value();
    worker.join();
  }
  ASSERT_TRUE(context->make_current());
}

TEST_F(ContextTest, ManyContextsInTurn) {
  for (int i = 0; i < 20; ++i) {
    const Context other = make_context(ContextPlatform::kAutomatic);
    EXPECT_NE(&other.functions(), &gl());
  }
  ASSERT_TRUE(context->make_current());
}

int draw_calls = 0;
void APIENTRY count_draw(GLenum, GLint, GLsizei) {
  ++draw_calls;
}

TEST_F(ContextTest, ATableCanBeCopiedAndItsCallsCounted) {
  Functions counted = gl();
  counted.DrawArrays = &count_draw;
  draw_calls = 0;
  counted.DrawArrays(GL_TRIANGLES, 0, 3);
  EXPECT_EQ(draw_calls, 1);
}

}  // namespace
}  // namespace sightline::gl::context_test
