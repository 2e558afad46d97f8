#include "sightline/importers/file_bytes.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <system_error>

#include <fmt/format.h>

namespace sightline::importers {
namespace {

constexpr std::size_t kBufferBytes = 1u << 20;

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

std::FILE* as_file(void* file) {
  return static_cast<std::FILE*>(file);
}

core::Error system_error(const std::filesystem::path& path, const char* what) {
  return {fmt::format("{}: {}: {}", path.string(), what, std::strerror(errno))};
}

}  // namespace

core::Expected<std::vector<std::byte>> read_file_bytes(const std::filesystem::path& path) {
  const std::unique_ptr<std::FILE, CloseFile> file(std::fopen(path.string().c_str(), "rb"));
  if (!file) return tl::unexpected(system_error(path, "cannot open"));
  std::error_code code;
  const auto size = std::filesystem::file_size(path, code);
  if (code) return core::fail(fmt::format("{}: cannot tell its size: {}", path.string(), code.message()));
  if (size == 0) return core::fail(fmt::format("{}: the file is empty", path.string()));
  try {
    std::vector<std::byte> bytes(size);
    const std::size_t got = std::fread(bytes.data(), 1, bytes.size(), file.get());
    if (std::ferror(file.get())) return tl::unexpected(system_error(path, "cannot read"));
    bytes.resize(got);
    return bytes;
  } catch (const std::exception&) {
    return core::fail(fmt::format("{}: {} bytes do not fit into memory", path.string(), size));
  }
}

ReplacingFileSink::ReplacingFileSink(std::filesystem::path target)
    : target_(std::move(target)), temporary_(target_.string() + ".part") {}

ReplacingFileSink::~ReplacingFileSink() {
  if (!file_) return;
  std::fclose(as_file(file_));
  std::remove(temporary_.string().c_str());
}

core::Expected<void> ReplacingFileSink::open() {
  if (std::error_code ignored; std::filesystem::is_directory(target_, ignored))
    return core::fail(fmt::format("{}: is a directory, expected a file name to write to", target_.string()));
  file_ = std::fopen(temporary_.string().c_str(), "wb");
  if (!file_) return tl::unexpected(system_error(temporary_, "cannot write"));
  std::setvbuf(as_file(file_), nullptr, _IOFBF, kBufferBytes);
  return {};
}

bool ReplacingFileSink::write(std::span<const std::byte> bytes) {
  return bytes.empty() || std::fwrite(bytes.data(), 1, bytes.size(), as_file(file_)) == bytes.size();
}

core::Expected<void> ReplacingFileSink::finish() {
  const bool closed = std::fclose(as_file(file_)) == 0;
  file_ = nullptr;
  core::Error error = closed ? core::Error{} : system_error(target_, "cannot write");
  if (closed) {
    std::error_code code;
    std::filesystem::rename(temporary_, target_, code);
    if (!code) return {};
    error.message = fmt::format("{}: cannot replace: {}", target_.string(), code.message());
  }
  std::remove(temporary_.string().c_str());
  return tl::unexpected(error);
}

}  // namespace sightline::importers
