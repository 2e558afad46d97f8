// Internal to writers of binary triangles: a file whose header has counts that a first pass over the model finds.
#pragma once

#include <bit>
#include <concepts>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "sightline/core/internal/atomic_file.h"
#include "sightline/importers/import.h"
#include "sightline/importers/internal/world_meshes.h"

namespace sightline::importers {

/// Bytes of a file, little-endian, written a megabyte at a time.
class TriangleFile {
 public:
  static core::Expected<TriangleFile> create(const std::filesystem::path& path) {
    auto file = core::AtomicFile::create(path);
    if (!file) return tl::unexpected(file.error());
    return TriangleFile(std::move(*file));
  }

  void put(std::string_view text) {
    buffer_.insert(buffer_.end(), text.begin(), text.end());
    if (buffer_.size() >= kFlushBytes) flush();
  }
  template <class Number>
  requires std::integral<Number> || std::floating_point<Number>
  void put(Number number) {
    static_assert(std::endian::native == std::endian::little);
    char bytes[sizeof number];
    std::memcpy(bytes, &number, sizeof number);
    put(std::string_view(bytes, sizeof number));
  }
  bool ok() const { return !file_.failed(); }
  std::uint64_t written() const { return written_ + buffer_.size(); }
  core::Expected<void> commit() {
    flush();
    return file_.commit();
  }

 private:
  static constexpr std::size_t kFlushBytes = std::size_t{1} << 20;
  explicit TriangleFile(core::AtomicFile file) : file_(std::move(file)) {}
  void flush() {
    (void)file_.write(std::as_bytes(std::span(buffer_)));
    written_ += buffer_.size();
    buffer_.clear();
  }

  core::AtomicFile file_;
  std::vector<char> buffer_;
  std::uint64_t written_ = 0;
};

/// What is written of a mesh in a pass over the model.
using MeshPass = std::function<void(TriangleFile&, const core::Mesh&, const core::Affine&, std::uint32_t material)>;

/// A pass that counts, `begin(file, counts)`, and then all the others one after the other.
inline core::Expected<WorldMeshReport> write_triangle_file(
    const WorldMeshes& meshes, const std::filesystem::path& path,
    const std::function<core::Expected<void>(TriangleFile&, const WorldMeshReport&)>& begin,
    std::span<const MeshPass> passes) {
  const auto failed = [&](const core::Error& error) {
    return tl::unexpected(
        error.message == kCancelled ? error : core::Error{fmt::format("{}: {}", path.string(), error.message)});
  };
  const double share = 1.0 / double(passes.size() + 1);
  const auto of_pass = [&](std::size_t pass) {
    WorldMeshes part{meshes.scene, meshes.node, meshes.tolerance};
    if (meshes.progress)
      part.progress = [&meshes, share, pass](double at) { return meshes.progress(share * (double(pass) + at)); };
    return part;
  };
  auto report = for_each_world_mesh(of_pass(0), [](const auto&...) -> core::Expected<void> { return {}; });
  if (!report) return failed(report.error());
  auto file = TriangleFile::create(path);
  if (!file) return tl::unexpected(file.error());
  if (auto done = begin(*file, *report); !done) return failed(done.error());
  for (std::size_t i = 0; i < passes.size(); ++i) {
    const auto done = for_each_world_mesh(
        of_pass(i + 1),
        [&](const core::Mesh& mesh, const core::Affine& world, std::uint32_t material) -> core::Expected<void> {
          passes[i](*file, mesh, world, material);
          return file->ok() ? core::Expected<void>() : core::fail("writing failed (is the disk full?)");
        });
    if (!done) return failed(done.error());
  }
  report->bytes = file->written();
  if (auto done = file->commit(); !done) return tl::unexpected(done.error());
  return report;
}

}  // namespace sightline::importers
