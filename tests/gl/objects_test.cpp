#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <functional>
#include <numeric>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "sightline/gl/internal/buffer.h"
#include "sightline/gl/internal/framebuffer.h"
#include "sightline/gl/internal/texture.h"
#include "sightline/gl/internal/timer.h"
#include "sightline/gl/internal/vertex_array.h"
#include "sightline/tests/support/faulty_gl.h"
#include "sightline/tests/support/gl_test.h"

namespace sightline::gl::objects_test {
namespace {

using ObjectsTest = tests::GlTest;

std::vector<std::uint32_t> counting(std::size_t count) {
  std::vector<std::uint32_t> values(count);
  std::iota(values.begin(), values.end(), 1000u);
  return values;
}

TEST_F(ObjectsTest, BufferRoundTrip) {
  const std::vector<std::uint32_t> values = counting(1000);
  auto buffer = Buffer::create(gl(), std::span(values), GL_DYNAMIC_STORAGE_BIT, "numbers");
  ASSERT_TRUE(buffer) << buffer.error().message;
  EXPECT_EQ(buffer->size(), 4000u);
  const std::array<std::uint32_t, 2> patch = {7, 8};
  buffer->write(40, sizeof patch, patch.data());
  std::vector<std::uint32_t> back(1000);
  buffer->read(0, buffer->size(), back.data());
  std::vector<std::uint32_t> expected = values;
  std::copy(patch.begin(), patch.end(), expected.begin() + 10);
  EXPECT_EQ(back, expected);
}

TEST_F(ObjectsTest, LargeBuffersWorkInMemoryOfOursAndOfTheDriver) {
  for (const bool pinned : {false, gl().pinned_memory}) {
    SCOPED_TRACE(pinned ? "memory of ours" : "memory of the driver");
    Functions table = gl();
    table.pinned_memory = pinned;
    std::vector<std::uint32_t> values = counting(2'000'000);
    auto made = Buffer::create(table, std::span(values), GL_DYNAMIC_STORAGE_BIT, "many numbers");
    ASSERT_TRUE(made) << made.error().message;
    EXPECT_EQ(made->memory() != nullptr, pinned);
    auto other = Buffer::create(table, values.size() * 4, nullptr, GL_DYNAMIC_STORAGE_BIT, "more numbers");
    ASSERT_TRUE(other) << other.error().message;
    Buffer buffer = std::move(*other);
    gl().CopyNamedBufferSubData(made->id(), buffer.id(), 0, 0, GLsizeiptr(made->size()));
    values[7] = 70;
    buffer.write(28, 4, &values[7]);
    buffer.fill(4'000'000, 400, 0xab);
    std::fill_n(values.begin() + 1'000'000, 100, 0xababababu);
    if (pinned) static_cast<std::uint32_t*>(buffer.memory())[1'999'999] = values[1'999'999] = 5;
    std::vector<std::uint32_t> back(values.size());
    buffer.read(0, buffer.size(), back.data());
    EXPECT_TRUE(back == values);
    const GLuint id = buffer.id();
    buffer = std::move(*made);  // frees the other one
    EXPECT_EQ(gl().IsBuffer(id), GL_FALSE);
    EXPECT_EQ(buffer.memory() != nullptr, pinned);
    buffer.read(0, 4, back.data());
    EXPECT_EQ(back[0], 1000u);
  }
}

// Where they are, llvmpipe compiles the programs that read them once more.
TEST_F(ObjectsTest, SizesAreNeitherPowersOfTwoNorWholePages) {
  for (const std::size_t bytes : {1u, 64u, 256u, 300u, 4096u, 65536u, 65600u, 1u << 20}) {
    const std::vector<std::uint8_t> data(bytes, 7);
    for (const void* from : {static_cast<const void*>(nullptr), static_cast<const void*>(data.data())}) {
      auto buffer = Buffer::create(gl(), bytes, from, GL_DYNAMIC_STORAGE_BIT, "bytes");
      ASSERT_TRUE(buffer) << buffer.error().message;
      EXPECT_EQ(buffer->size(), bytes);
      GLint64 allocated = 0;
      gl().GetNamedBufferParameteri64v(buffer->id(), GL_BUFFER_SIZE, &allocated);
      EXPECT_FALSE(std::has_single_bit(std::uint64_t(allocated))) << bytes;
      EXPECT_NE(allocated >> 8 & 0xff, 0) << bytes;
      if (!from) continue;
      std::vector<std::uint8_t> back(bytes);
      buffer->read(0, bytes, back.data());
      EXPECT_EQ(back, data);
    }
  }
}

TEST_F(ObjectsTest, BufferStaysMapped) {
  const GLbitfield access = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
  auto buffer = Buffer::create(gl(), 64, nullptr, access, "mapped");
  ASSERT_TRUE(buffer) << buffer.error().message;
  auto* words = static_cast<std::uint32_t*>(buffer->map(0, 64, access));
  ASSERT_NE(words, nullptr);
  words[3] = 99;
  std::uint32_t value = 0;
  buffer->read(12, 4, &value);
  EXPECT_EQ(value, 99u);
}

TEST_F(ObjectsTest, ImpossibleBuffersAreErrorsThatSayTheBytes) {
  const std::size_t wanted = std::size_t{1} << 60;
  const auto huge = Buffer::create(gl(), wanted, nullptr, 0, "everything");
  ASSERT_FALSE(huge);
  EXPECT_NE(huge.error().message.find("'everything'"), std::string::npos) << huge.error().message;
  EXPECT_NE(huge.error().message.find(std::to_string(wanted) + " bytes"), std::string::npos) << huge.error().message;
  context->take_errors();
  EXPECT_FALSE(Buffer::create(gl(), 0, nullptr, 0, "nothing"));
  EXPECT_FALSE(Buffer::create(gl(), ~std::size_t{0}, nullptr, 0, "more than can be said"));
}

TEST_F(ObjectsTest, MovedObjectsAreOwnedOnce) {
  auto made = Buffer::create(gl(), 16, nullptr, 0, "moved");
  ASSERT_TRUE(made) << made.error().message;
  const GLuint id = made->id();
  Buffer first = std::move(*made);
  Buffer second;
  second = std::move(first);
  EXPECT_EQ(second.id(), id);
  EXPECT_EQ(first.id(), 0u);  // NOLINT(bugprone-use-after-move): what this test is about
  EXPECT_TRUE(gl().IsBuffer(id));
  second = Buffer();
  EXPECT_FALSE(gl().IsBuffer(id));
}

TEST_F(ObjectsTest, TextureBufferChecksFormatAndLimit) {
  auto buffer = Buffer::create(gl(), 120, nullptr, 0, "texels");
  ASSERT_TRUE(buffer) << buffer.error().message;
  const auto view = TextureBuffer::create(gl(), *buffer, GL_RGB32F, "view");
  ASSERT_TRUE(view) << view.error().message;
  EXPECT_EQ(view->texels(), 10);
  EXPECT_FALSE(TextureBuffer::create(gl(), *buffer, GL_RGB8, "view"));

  const auto limit = static_cast<std::size_t>(context->capabilities().max_texture_buffer_texels);
  if (limit > (std::size_t{1} << 28)) return;  // would take too much memory to exceed
  auto large = Buffer::create(gl(), limit + 1, nullptr, 0, "large");
  ASSERT_TRUE(large) << large.error().message;
  const auto beyond = TextureBuffer::create(gl(), *large, GL_R8UI, "beyond");
  ASSERT_FALSE(beyond);
  EXPECT_NE(beyond.error().message.find("limit is " + std::to_string(limit)), std::string::npos);
}

TEST_F(ObjectsTest, TextureRoundTripWithOddRows) {
  auto texture = Texture2D::create(gl(), 3, 5, GL_R8UI, "odd");
  ASSERT_TRUE(texture) << texture.error().message;
  std::array<std::uint8_t, 15> pixels{};
  std::iota(pixels.begin(), pixels.end(), std::uint8_t{1});
  texture->write(GL_RED_INTEGER, GL_UNSIGNED_BYTE, std::as_bytes(std::span(pixels)));
  std::array<std::uint8_t, 15> back{};
  texture->read(0, GL_RED_INTEGER, GL_UNSIGNED_BYTE, std::as_writable_bytes(std::span(back)));
  EXPECT_EQ(back, pixels);
  GLint alignment = 0;
  gl().GetIntegerv(GL_PACK_ALIGNMENT, &alignment);
  EXPECT_EQ(alignment, 4) << "an application's setting";
}

TEST_F(ObjectsTest, ImpossibleTexturesAreErrors) {
  const int limit = context->capabilities().max_texture_size;
  EXPECT_FALSE(Texture2D::create(gl(), limit + 1, 1, GL_RGBA8, "wide"));
  EXPECT_FALSE(Texture2D::create(gl(), 0, 1, GL_RGBA8, "flat"));
  EXPECT_FALSE(Texture2D::create(gl(), 8, 8, GL_RGBA8, "many", 1000));
  EXPECT_TRUE(context->take_errors().empty()) << "found before GL was asked";
  const auto unsized = Texture2D::create(gl(), 8, 8, GL_RGBA, "unsized");
  ASSERT_FALSE(unsized);
  EXPECT_NE(unsized.error().message.find("GL_INVALID_ENUM"), std::string::npos) << unsized.error().message;
  context->take_errors();
}

TEST_F(ObjectsTest, MultisampledColorResolves) {
  auto many = Texture2D::create(gl(), 8, 8, GL_RGBA8, "many", 4);
  auto one = Texture2D::create(gl(), 8, 8, GL_RGBA8, "one");
  ASSERT_TRUE(many && one);
  const std::array<Attachment, 1> from = {{{GL_COLOR_ATTACHMENT0, &*many, 0}}};
  const std::array<Attachment, 1> to = {{{GL_COLOR_ATTACHMENT0, &*one, 0}}};
  auto source = Framebuffer::create(gl(), from, "source");
  auto target = Framebuffer::create(gl(), to, "target");
  ASSERT_TRUE(source && target);
  const std::array<float, 4> color = {0.0f, 1.0f, 0.0f, 1.0f};
  gl().ClearNamedFramebufferfv(source->id(), GL_COLOR, 0, color.data());
  gl().BlitNamedFramebuffer(source->id(), target->id(), 0, 0, 8, 8, 0, 0, 8, 8, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  std::array<std::uint32_t, 64> pixels{};
  one->read(0, GL_RGBA, GL_UNSIGNED_BYTE, std::as_writable_bytes(std::span(pixels)));
  EXPECT_TRUE(std::all_of(pixels.begin(), pixels.end(), [](std::uint32_t p) { return p == 0xff00ff00u; }));
}

TEST_F(ObjectsTest, IncompleteFramebufferIsAnErrorThatSaysWhy) {
  auto color = Texture2D::create(gl(), 8, 8, GL_RGBA8, "color");
  ASSERT_TRUE(color);
  const std::array<Attachment, 1> misplaced = {{{GL_DEPTH_ATTACHMENT, &*color, 0}}};
  const auto framebuffer = Framebuffer::create(gl(), misplaced, "misplaced");
  ASSERT_FALSE(framebuffer);
  EXPECT_NE(framebuffer.error().message.find("incomplete attachment"), std::string::npos)
      << framebuffer.error().message;
  EXPECT_FALSE(Framebuffer::create(gl(), {}, "empty"));
  context->take_errors();
}

std::vector<GLuint> asked_queries;
const Functions* real_functions = nullptr;
void APIENTRY record_query(GLuint query, GLenum name, GLuint64* value) {
  asked_queries.push_back(query);
  real_functions->GetQueryObjectui64v(query, name, value);
}

TEST_F(ObjectsTest, TimerReadsEachQueryOfTheRing) {
  Functions recording = gl();
  real_functions = &gl();
  asked_queries.clear();
  recording.GetQueryObjectui64v = &record_query;
  GpuTimer timer(recording);
  for (std::size_t i = 0; i < 3 * GpuTimer::kSlots; ++i) {
    ASSERT_TRUE(timer.begin());
    timer.end();
    gl().Finish();
    ASSERT_TRUE(timer.poll());
  }
  std::sort(asked_queries.begin(), asked_queries.end());
  ASSERT_EQ(asked_queries.size(), 6 * GpuTimer::kSlots);
  EXPECT_EQ(std::unique(asked_queries.begin(), asked_queries.end()) - asked_queries.begin(), 2 * GpuTimer::kSlots);
}

TEST_F(ObjectsTest, TimerNeverWaitsAndGivesEachSpanOnce) {
  GpuTimer timer(gl());
  EXPECT_FALSE(timer.poll());
  for (std::size_t i = 0; i < GpuTimer::kSlots; ++i) {
    EXPECT_TRUE(timer.begin());
    timer.end();
  }
  EXPECT_FALSE(timer.begin()) << "the ring is full";
  timer.end();
  EXPECT_EQ(timer.pending(), GpuTimer::kSlots);
  gl().Finish();
  GpuTimer moved = std::move(timer);
  std::size_t spans = 0;
  while (const auto milliseconds = moved.poll()) {
    EXPECT_GE(*milliseconds, 0.0);
    ++spans;
  }
  EXPECT_EQ(spans, GpuTimer::kSlots);
  EXPECT_TRUE(moved.begin());
  moved.end();
}

TEST_F(ObjectsTest, VertexArrayBinds) {
  const VertexArray vertices(gl());
  vertices.bind();
  GLint bound = 0;
  gl().GetIntegerv(GL_VERTEX_ARRAY_BINDING, &bound);
  EXPECT_EQ(static_cast<GLuint>(bound), vertices.id());
}

/// Whichever call fails: the error names the object, and no call is made with what is not there.
TEST_F(ObjectsTest, WhatCannotBeMadeIsAnErrorThatNamesIt) {
  const auto buffer = Buffer::create(gl(), 64, nullptr, 0, "texels");
  const auto texture = Texture2D::create(gl(), 4, 4, GL_RGBA8, "image");
  ASSERT_TRUE(buffer && texture);
  const Attachment attachment{GL_COLOR_ATTACHMENT0, &*texture};
  const auto message = [](const auto& made) { return made ? std::string() : made.error().message; };
  const std::function<std::string()> makers[] = {
      [&] { return message(Buffer::create(gl(), 64, nullptr, 0, "thing")); },
      [&] { return message(TextureBuffer::create(gl(), *buffer, GL_R32UI, "thing")); },
      [&] { return message(Texture2D::create(gl(), 4, 4, GL_RGBA8, "thing")); },
      [&] { return message(Texture2D::create(gl(), 4, 4, GL_RGBA8, "thing", 4)); },
      [&] {
        return message(Framebuffer::create(gl(), {&attachment, 1}, "thing"));
      },
      [&] { return message(Framebuffer::create_attachmentless(gl(), 4, 4, "thing")); },
  };
  tests::FaultyGl faulty(*context);
  for (const auto& make : makers) {
    faulty.reset();
    EXPECT_EQ(make(), "");
    const int fallible = faulty.fallible();
    EXPECT_GE(fallible, 2);
    for (int number = 0; number < fallible; ++number) {
      faulty.reset();
      faulty.fail(number);
      EXPECT_NE(make().find("'thing'"), std::string::npos) << faulty.failed_first();
      for (const std::string& error : context->take_errors()) ADD_FAILURE() << faulty.failed_first() << ": " << error;
    }
  }
}

TEST_F(ObjectsTest, LargeBuffersTakeTheDriversMemoryWhereOursIsRefused) {
  if (!gl().pinned_memory) GTEST_SKIP() << "the driver takes no memory of ours";
  tests::FaultyGl faulty(*context);
  faulty.fail(1);  // after the name
  const auto buffer = Buffer::create(gl(), std::size_t(8) << 20, nullptr, GL_DYNAMIC_STORAGE_BIT, "large");
  EXPECT_EQ(faulty.failed_first(), "BufferData");
  ASSERT_TRUE(buffer) << buffer.error().message;
  EXPECT_EQ(buffer->memory(), nullptr);
}

TEST_F(ObjectsTest, TimersWithoutQueriesMeasureNothing) {
  tests::FaultyGl faulty(*context);
  faulty.fail(0);
  GpuTimer timer(gl());
  EXPECT_FALSE(timer.begin());
  timer.end();
  EXPECT_FALSE(timer.poll());
}

}  // namespace
}  // namespace sightline::gl::objects_test
