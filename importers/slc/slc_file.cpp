#include "sightline/importers/slc/internal/slc_file.h"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstring>
#include <system_error>
#include <thread>

#include <fmt/format.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "sightline/core/thread_pool.h"
#include "sightline/importers/slc/internal/storage.h"

namespace sightline::importers {
namespace {

constexpr std::uint32_t kEndianMark = 0x01020304, kOtherEndian = 0x04030201;
constexpr std::size_t kAlignment = 64;
// Elements per checksum. So many slots are one subtree of the culling hierarchy: 32 in a leaf, sixteen children twice
// and thrice.
constexpr std::uint64_t kBlockElements = std::uint64_t(32) << 12;
constexpr std::uint64_t kBlockBytes = std::uint64_t(1) << 20;  // of arrays of bytes

/// The first bytes of the file, in every version.
struct Header {
  std::array<unsigned char, 8> magic;
  std::uint32_t version, endian_mark;
  std::uint64_t layout;
  std::uint64_t reserved[4];
  std::uint64_t checksum;  // of the bytes before
};
static_assert(sizeof(Header) == 64);
constexpr std::array<unsigned char, 8> kMagic{0x89, 'S', 'L', 'C', '\r', '\n', 0x1a, '\n'};

/// The last bytes.
struct Trailer {
  std::uint64_t table_offset, table_bytes, table_checksum, file_size;
  std::uint64_t reserved[3];
  std::uint64_t checksum;  // of the bytes before
};
static_assert(sizeof(Trailer) == 64);

template <class T>
std::uint64_t checksum_before_last(const T& block) {
  return slc_checksum(std::as_bytes(std::span(&block, 1)).first(sizeof(T) - sizeof(std::uint64_t)));
}

std::uint64_t block_elements(std::uint64_t element_size) {
  return element_size == 1 ? kBlockBytes : kBlockElements;
}

std::uint64_t block_count(const SlcFile::Section& section) {
  const std::uint64_t per_block = block_elements(section.element_size);
  return section.count / per_block + (section.count % per_block != 0 ? 1 : 0);
}

}  // namespace

std::uint64_t slc_checksum(std::span<const std::byte> bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

std::uint64_t slc_checksum(const std::filesystem::path& path) {
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  const std::unique_ptr<std::FILE, Close> file(core::platform::open_file(path, "rb"));
  const std::unique_ptr<XXH3_state_t, XXH_errorcode (*)(XXH3_state_t*)> state(XXH3_createState(), XXH3_freeState);
  if (!file || !state) return 0;
  XXH3_64bits_reset(state.get());
  std::vector<std::byte> buffer(kBlockBytes);
  while (const std::size_t got = std::fread(buffer.data(), 1, buffer.size(), file.get()))
    XXH3_64bits_update(state.get(), buffer.data(), got);
  return std::ferror(file.get()) ? 0 : XXH3_64bits_digest(state.get());
}

// --- writing ---------------------------------------------------------------------------------------------------------

struct SlcWriter::State {
  core::AtomicFile* file = nullptr;
  std::uint64_t written = 0;
  std::vector<SlcFile::Section> sections;
  std::vector<std::uint64_t> checksums;
  XXH3_state_t* hash = XXH3_createState();
  std::uint64_t block_left = 0;  // bytes until the block ends
};

void SlcWriter::Delete::operator()(State* state) const {
  XXH3_freeState(state->hash);
  delete state;
}

SlcWriter::SlcWriter(core::AtomicFile& file) : state_(new State) {
  state_->file = &file;
  Header header{kMagic, kSlcVersion, kEndianMark, storage::layout(), {}, 0};
  header.checksum = checksum_before_last(header);
  write(std::as_bytes(std::span(&header, 1)));
}

void SlcWriter::write(std::span<const std::byte> bytes) {
  state_->file->write(bytes);
  state_->written += bytes.size();
}

void SlcWriter::pad() {
  constexpr std::byte kZeros[kAlignment] = {};
  if (const std::uint64_t over = state_->written % kAlignment; over != 0)
    write(std::span(kZeros).first(kAlignment - over));
}

void SlcWriter::begin(std::uint64_t number, std::size_t element_size) {
  pad();
  state_->sections.push_back({number, element_size, 0, state_->written, state_->checksums.size(), 0});
  state_->block_left = 0;
}

void SlcWriter::append(std::span<const std::byte> bytes) {
  SlcFile::Section& section = state_->sections.back();
  while (!bytes.empty()) {
    if (state_->block_left == 0) {
      XXH3_64bits_reset(state_->hash);
      state_->block_left = block_elements(section.element_size) * section.element_size;
      ++section.blocks;
    }
    const auto part = bytes.first(std::size_t(std::min<std::uint64_t>(bytes.size(), state_->block_left)));
    XXH3_64bits_update(state_->hash, part.data(), part.size());
    write(part);
    state_->block_left -= part.size();
    if (state_->block_left == 0) state_->checksums.push_back(XXH3_64bits_digest(state_->hash));
    bytes = bytes.subspan(part.size());
  }
}

void SlcWriter::end() {
  SlcFile::Section& section = state_->sections.back();
  if (state_->block_left != 0) state_->checksums.push_back(XXH3_64bits_digest(state_->hash));
  section.count = (state_->written - section.offset) / section.element_size;
}

void SlcWriter::finish() {
  pad();
  std::vector<std::uint64_t> table{state_->sections.size()};
  for (const SlcFile::Section& s : state_->sections)
    table.insert(table.end(), {s.number, s.element_size, s.count, s.offset, s.first_block, s.blocks});
  table.insert(table.end(), state_->checksums.begin(), state_->checksums.end());
  const auto bytes = std::as_bytes(std::span(table));
  Trailer trailer{state_->written, bytes.size(), slc_checksum(bytes), 0, {}, 0};
  write(bytes);
  pad();
  trailer.file_size = state_->written + sizeof trailer;
  trailer.checksum = checksum_before_last(trailer);
  write(std::as_bytes(std::span(&trailer, 1)));
}

// --- reading ---------------------------------------------------------------------------------------------------------

SlcExpected<std::shared_ptr<const SlcFile>> SlcFile::open(const std::filesystem::path& path) {
  const std::shared_ptr<SlcFile> file(new SlcFile);
  auto opened = core::platform::ReadableFile::open(path);
  if (!opened) {
    const std::error_code& why = opened.error();
    const bool missing = why == std::errc::no_such_file_or_directory || why == std::errc::not_a_directory;
    return tl::unexpected<SlcProblem>(SlcProblem{missing ? SlcProblem::Kind::kMissing : SlcProblem::Kind::kDamaged,
                                                 fmt::format("cannot open: {}", why.message())});
  }
  if (!opened->is_regular()) return damaged("not a regular file");
  file->file_ = std::move(*opened);
  file->size_ = std::size_t(file->file_.size());
  if (file->size_ < sizeof(Header) + sizeof(Trailer))
    return damaged(fmt::format("{} bytes are no scene cache", file->size_));
  const auto mapping = file->map_to_read();
  if (!mapping) return tl::unexpected(mapping.error());
  if (auto read = file->read_table(mapping->data); !read) return tl::unexpected(read.error());
  return file;
}

SlcExpected<std::shared_ptr<const SlcFile>> SlcFile::of_bytes(std::span<const std::byte> bytes) {
  const std::shared_ptr<SlcFile> file(new SlcFile);
  if (bytes.size() < sizeof(Header) + sizeof(Trailer))
    return damaged(fmt::format("{} bytes are no scene cache", bytes.size()));
  file->memory_.assign(bytes.begin(), bytes.end());
  file->size_ = bytes.size();
  if (auto read = file->read_table(file->memory_.data()); !read) return tl::unexpected(read.error());
  return file;
}

SlcExpected<SlcFile::Mapping> SlcFile::map() const {
  return mapped(Access::kWriteCopy);
}
SlcExpected<SlcFile::Mapping> SlcFile::map_to_read() const {
  return mapped(Access::kRead);
}

SlcExpected<SlcFile::Mapping> SlcFile::mapped(Access access) const {
  if (!file_.is_open()) {
    void* const memory = core::allocate_lines(size_);
    std::memcpy(memory, memory_.data(), size_);
    const std::size_t size = size_;
    return Mapping{std::shared_ptr<const void>(memory, [size](void* m) { core::release_lines(m, size); }),
                   static_cast<std::byte*>(memory)};
  }
  auto memory = file_.map(access);
  if (!memory) return damaged(fmt::format("cannot be mapped: {}", memory.error().message()));
  std::byte* const data = memory->get();
  return Mapping{std::move(*memory), data};
}

SlcExpected<void> SlcFile::read(std::uint64_t offset, std::span<std::byte> to) const {
  if (!file_.is_open()) {
    std::copy_n(memory_.begin() + std::ptrdiff_t(offset), to.size(), to.begin());
    return {};
  }
  const auto got = file_.read(offset, to);
  if (!got) return damaged(fmt::format("cannot be read: {}", got.error().message()));
  if (*got < to.size()) return damaged("it was cut short while it was open");
  return {};
}

void SlcFile::set_aside(const Mapping& mapping, std::uint64_t number) const {
  const Section* section = find(number);
  if (!file_.is_open() || !section) return;
  core::platform::set_aside(mapping.data, section->offset, section->offset + section->count * section->element_size);
}

const SlcFile::Section* SlcFile::find(std::uint64_t number) const {
  const auto found =
      std::find_if(sections_.begin(), sections_.end(), [&](const Section& s) { return s.number == number; });
  return found == sections_.end() ? nullptr : &*found;
}

SlcExpected<void> SlcFile::read_table(const std::byte* data) {
  Header header;
  std::memcpy(&header, data, sizeof header);
  if (header.magic != kMagic) return damaged("it does not begin as a scene cache");
  const auto other = [](std::string message) {
    return tl::unexpected<SlcProblem>(SlcProblem{SlcProblem::Kind::kOtherVersion, std::move(message)});
  };
  if (header.endian_mark == kOtherEndian) return other("it was written on a machine with another byte order");
  if (header.checksum != checksum_before_last(header)) return damaged("its header does not match its checksum");
  if (header.version != kSlcVersion)
    return other(fmt::format("format version {}, expected {}", header.version, kSlcVersion));
  if (header.layout != storage::layout()) return other("it was written by another build, with another layout");

  Trailer trailer;
  std::memcpy(&trailer, data + size_ - sizeof trailer, sizeof trailer);
  if (trailer.checksum != checksum_before_last(trailer) || trailer.file_size != size_)
    return damaged("its end does not match its checksum: it is cut short or was overwritten");
  const std::uint64_t end = size_ - sizeof trailer;
  if (trailer.table_offset % kAlignment != 0 || trailer.table_offset > end || trailer.table_bytes % 8 != 0 ||
      trailer.table_bytes < 8 || trailer.table_bytes > end - trailer.table_offset)
    return damaged("its table lies outside the file");
  const std::span<const std::byte> bytes(data + trailer.table_offset, std::size_t(trailer.table_bytes));
  if (trailer.table_checksum != slc_checksum(bytes)) return damaged("its table does not match its checksum");
  std::vector<std::uint64_t> table(bytes.size() / 8);
  std::memcpy(table.data(), bytes.data(), bytes.size());

  constexpr std::uint64_t kWords = sizeof(Section) / 8;
  const std::uint64_t count = table[0];
  if (count > (table.size() - 1) / kWords) return damaged("its table has no room for its arrays");
  sections_.resize(std::size_t(count));
  if (count > 0) std::memcpy(sections_.data(), table.data() + 1, std::size_t(count) * sizeof(Section));
  checksums_.assign(table.begin() + std::ptrdiff_t(1 + count * kWords), table.end());
  std::uint64_t at = sizeof(Header), block = 0;
  // Arrays follow each other, with zeros up to the next line between them.
  const auto zeros = [&](std::uint64_t from, std::uint64_t to) {
    return std::all_of(data + from, data + to, [](std::byte b) { return b == std::byte{0}; });
  };
  for (const Section& s : sections_) {
    if (s.offset % kAlignment != 0 || s.offset < at || s.offset - at >= kAlignment || s.element_size == 0 ||
        s.offset > trailer.table_offset || s.count > (trailer.table_offset - s.offset) / s.element_size ||
        s.first_block != block || s.blocks != block_count(s))
      return damaged("its table is inconsistent");
    if (!zeros(at, s.offset)) return damaged("the gaps between its arrays are not empty");
    at = s.offset + s.count * s.element_size;
    block += s.blocks;
  }
  const std::uint64_t table_end = trailer.table_offset + trailer.table_bytes;
  if (block != checksums_.size() || trailer.table_offset - at >= kAlignment || end - table_end >= kAlignment)
    return damaged("its table is inconsistent");
  if (!zeros(at, trailer.table_offset) || !zeros(table_end, end))
    return damaged("the gaps between its arrays are not empty");
  return {};
}

SlcExpected<void> SlcFile::verify(std::span<const Verified> what) const {
  struct Block {
    std::span<const std::byte> bytes;
    std::uint64_t checksum, number;
  };
  std::vector<Block> blocks;
  for (const auto& [section, mapping] : what) {
    const std::uint64_t step = block_elements(section->element_size) * section->element_size;
    const std::uint64_t bytes = section->count * section->element_size;
    for (std::uint64_t b = 0; b < section->blocks; ++b)
      blocks.push_back({{mapping->data + section->offset + b * step, std::size_t(std::min(step, bytes - b * step))},
                        checksums_[std::size_t(section->first_block + b)],
                        section->number});
  }
  std::atomic<std::uint64_t> wrong{0};
  const auto check = [&](std::uint32_t i) {
    if (wrong == 0 && slc_checksum(blocks[i].bytes) != blocks[i].checksum) wrong = blocks[i].number;
  };
  const std::size_t processors = std::max(1u, std::thread::hardware_concurrency());
  core::ThreadPool(int(std::min(processors, blocks.size()))).run_at_once(std::uint32_t(blocks.size()), check);
  if (wrong != 0) return damaged(fmt::format("array {} does not match its checksum", wrong.load()));
  return {};
}

}  // namespace sightline::importers
