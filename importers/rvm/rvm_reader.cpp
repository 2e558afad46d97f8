#include "sightline/importers/rvm/internal/rvm_reader.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sightline/importers/internal/text_encoding.h"
#include "sightline/importers/rvm/internal/rvm_chunks.h"
#include "sightline/importers/rvm/internal/rvm_scene_builder.h"
#include "sightline/importers/rvm/internal/rvm_text.h"

namespace sightline::importers {
namespace {

/// Walks the chunks.
class RvmWalk {
 public:
  /// `places`: of a text, where its chunks stand; none for a binary file.
  RvmWalk(std::span<const std::byte> bytes, ImportJob& job, std::span<const RvmTextPlace> places = {})
      : bytes_(bytes), job_(job), places_(places), builder_(job) {}

  core::Expected<void> run() {
    job_.report().bytes = bytes_.size();
    job_.report().metres_per_unit = 0.001;
    job_.promise_reach();
    if (auto begun = begin(); !begun) return begun;
    while (!ended_) {
      if (auto stepped = step(); !stepped) return stepped;
      const double share = double(at_) / double(bytes_.size());
      if (auto asked = job_.progress(places_.empty() ? share : 0.5 + 0.5 * share); !asked) return asked;
    }
    builder_.finish();
    return {};
  }

 private:
  core::Error error(std::uint64_t offset, std::string_view tag, std::string_view message) const {
    const RvmTextPlace* place = place_of(offset);
    const std::string where = place ? fmt::format("line {}", place->line) : fmt::format("byte {}", offset);
    if (tag.empty()) return {fmt::format("{}: {}: {}", job_.file(), where, message)};
    return {fmt::format("{}: {}: {} chunk: {}", job_.file(), where, tag, message)};
  }

  /// The chunk of a text that the offset lies in.
  const RvmTextPlace* place_of(std::uint64_t offset) const {
    if (places_.empty()) return nullptr;
    const auto behind =
        std::upper_bound(places_.begin(), places_.end(), offset,
                         [](std::uint64_t at, const RvmTextPlace& place) { return at < place.image_offset; });
    return behind == places_.begin() ? &places_[0] : &*(behind - 1);
  }

  void warn(std::uint64_t offset, std::string_view tag, std::string_view message) {
    const RvmTextPlace* place = place_of(offset);
    const std::string line = place ? fmt::format("line {}: ", place->line) : "";
    job_.warn(place ? place->text_offset : offset,
              tag.empty() ? line + std::string(message) : fmt::format("{}{} chunk: {}", line, tag, message));
  }

  /// Damage: an error when strict, a warning when lenient.
  core::Expected<void> damage(std::uint64_t offset, std::string_view tag, std::string_view message) {
    if (!job_.options().lenient) return tl::unexpected(error(offset, tag, message));
    warn(offset, tag, message);
    return {};
  }

  /// The HEAD chunk.
  core::Expected<void> begin() {
    const auto header = rvm::read_header(bytes_, 0);
    if (!header || header->name() != "HEAD")
      return tl::unexpected(error(0, "", "not an RVM file: expected a HEAD chunk (24 bytes, 'H' in byte 3)"));
    rvm::ByteCursor cursor(bytes_, rvm::kHeaderBytes, limit_of(*header));
    const rvm::Head head = rvm::read_head(cursor);
    if (!cursor.ok()) return tl::unexpected(error(cursor.error_offset(), "HEAD", cursor.error()));
    builder_.add(head);
    return advance(*header, cursor.position());
  }

  bool next_is_valid(const rvm::ChunkHeader& header) const {
    return header.next >= header.offset + rvm::kHeaderBytes && header.next <= bytes_.size();
  }

  bool leads_to_chunk(std::uint64_t offset) const {
    const auto header = rvm::read_header(bytes_, offset);
    return header && rvm::is_known_tag(header->name());
  }

  /// The first place from there on that looks like a chunk; the file's size if there is none.
  std::uint64_t find_chunk(std::uint64_t from) const {
    for (std::uint64_t at = from; at + rvm::kHeaderBytes <= bytes_.size(); ++at) {
      if (bytes_[at] != std::byte{0}) continue;  // tags are characters of four bytes each
      const auto header = rvm::read_header(bytes_, at);
      if (header && rvm::is_known_tag(header->name()) && (header->name() == "END:" || next_is_valid(*header)))
        return at;
    }
    return bytes_.size();
  }

  /// Where the contents of a chunk must end: where its header says that the next one begins. Programs that rewrite a
  /// file may leave offsets of the former one, which then lead into the contents; so an offset that leads to no chunk
  /// counts only where the contents do not reach just up to one. The contents are read no farther than that, so that
  /// the time stays linear.
  std::uint64_t limit_of(const rvm::ChunkHeader& header) const {
    if (!next_is_valid(header)) return bytes_.size();
    if (!rvm::is_known_tag(header.name()) || rvm::read_header(bytes_, header.next)) return header.next;
    const std::uint64_t begin = header.offset + rvm::kHeaderBytes, end = find_chunk(begin);
    rvm::ByteCursor cursor(bytes_, begin, end);
    pass_body(header.name(), cursor);
    return cursor.ok() && cursor.position() == end ? end : header.next;
  }

  /// Reads contents without a use.
  void pass_body(std::string_view tag, rvm::ByteCursor& cursor) const {
    if (tag == "PRIM" || tag == "OBST" || tag == "INSU") rvm::read_item(cursor, bytes_, tag != "PRIM");
    if (tag == "HEAD") rvm::read_head(cursor);
    if (tag == "MODL") rvm::read_model(cursor);
    if (tag == "CNTB") rvm::read_group(cursor);
    if (tag == "CNTE") cursor.u32("version");
    if (tag == "COLR") rvm::read_colour(cursor);
  }

  /// Moves on to the next chunk. The body ended at `body_end`. Where that and the header disagree, the offset that
  /// holds a chunk is trusted, which loses nothing. Never goes back, so every byte is read once.
  core::Expected<void> advance(const rvm::ChunkHeader& header, std::uint64_t body_end) {
    at_ = header.next;
    if (header.next == body_end) return {};
    const std::string message =
        fmt::format("the next chunk is said to begin at byte {}, the contents end at byte {}", header.next, body_end);
    const bool next_valid = next_is_valid(header), behind_body = leads_to_chunk(body_end);
    if (behind_body || !next_valid) at_ = body_end;
    // Later programs say more in a head than is known of it.
    const bool longer_head = header.name() == "HEAD" && next_valid && leads_to_chunk(header.next);
    if (!behind_body && !longer_head) return damage(header.offset, header.name(), message);
    warn(header.offset, header.name(), message);
    return {};
  }

  /// After damage, in a lenient import: goes on at the next place that looks like a chunk.
  void resynchronise(std::uint64_t from) {
    const std::uint64_t found = find_chunk(from);
    ended_ = found == bytes_.size();
    if (ended_) return;
    warn(from, "",
         fmt::format("{} bytes skipped, up to a {} chunk at byte {}", found - from,
                     rvm::read_header(bytes_, found)->name(), found));
    at_ = found;
  }

  core::Expected<void> step() {
    const auto header = rvm::read_header(bytes_, at_);
    if (!header) {
      auto tolerated = damage(at_, "",
                              at_ >= bytes_.size() ? "the file ends without an END: chunk"
                                                   : "expected a chunk header (24 bytes), found something else");
      resynchronise(at_ + 1);
      return tolerated;
    }
    const std::string_view tag = header->name();
    if (tag == "END:") {
      ended_ = true;
      return depth_ == 0 ? core::Expected<void>{}
                         : damage(at_, tag, fmt::format("expected {} more CNTE: groups are not closed", depth_));
    }
    rvm::ByteCursor cursor(bytes_, at_ + rvm::kHeaderBytes, limit_of(*header));
    auto understood = read_body(tag, cursor);
    if (!understood) return tl::unexpected(understood.error());
    if (cursor.ok() && *understood) return advance(*header, cursor.position());
    // The contents are lost, but the header may still say where the next chunk is.
    auto tolerated = cursor.ok() ? core::Expected<void>{} : damage(cursor.error_offset(), tag, cursor.error());
    const std::uint64_t behind_header = at_ + rvm::kHeaderBytes;
    at_ = header->next;
    if (!next_is_valid(*header)) resynchronise(behind_header);
    return tolerated;
  }

  /// False for an unknown kind of chunk.
  core::Expected<bool> read_body(std::string_view tag, rvm::ByteCursor& cursor) {
    if (tag == "PRIM") return read_item(tag, core::kLayerModel, cursor);
    if (tag == "CNTB") return read_group(cursor);
    if (tag == "CNTE") return close_group(cursor);
    if (tag == "OBST") return read_item(tag, core::kLayerObstruction, cursor);
    if (tag == "INSU") return read_item(tag, core::kLayerInsulation, cursor);
    if (tag == "COLR") {
      const rvm::Colour colour = rvm::read_colour(cursor);
      if (cursor.ok()) builder_.add(colour);
      return true;
    }
    if (tag == "MODL") {
      const rvm::Model model = rvm::read_model(cursor);
      if (cursor.ok()) builder_.add(model, at_);
      return true;
    }
    auto tolerated = damage(at_, tag, tag == "HEAD" ? "a second one; skipped" : "unknown; skipped");
    if (!tolerated) return tl::unexpected(tolerated.error());
    return false;
  }

  core::Expected<bool> read_group(rvm::ByteCursor& cursor) {
    rvm::Group group = rvm::read_group(cursor);
    if (!cursor.ok()) group = {};  // keeps the nesting right
    for (const float value : group.position)
      if (!std::isfinite(value)) {
        warn(at_, "CNTB", "the reference point is not finite; left out");
        group.position = {};
      }
    ++depth_;
    builder_.open(group, at_);
    return true;
  }

  core::Expected<bool> close_group(rvm::ByteCursor& cursor) {
    cursor.u32("version");
    if (depth_ == 0) {
      warn(at_, "CNTE", "no group is open");
      return true;
    }
    --depth_;
    builder_.close();
    return true;
  }

  core::Expected<bool> read_item(std::string_view tag, std::uint32_t layers, rvm::ByteCursor& cursor) {
    const rvm::Item item = rvm::read_item(cursor, bytes_, layers != core::kLayerModel);
    if (!cursor.ok()) return true;
    if (depth_ == 0)
      if (auto tolerated = damage(at_, tag, "expected to lie in a group (CNTB), but none is open"); !tolerated)
        return tl::unexpected(tolerated.error());
    if (item.ambiguous)
      warn(at_, tag, "the bounding box fits neither known layout; taken as box, extra word, parameters");
    if (!item.finite) {
      warn(at_, tag, "dropped: a number is not finite");
    } else if (item.reach > kLargestCoordinate) {
      warn(at_, tag,
           fmt::format("dropped: reaches {:.3g} m, expected at most {:.3g} m", item.reach, kLargestCoordinate));
    } else {
      if (item.bad_polygons > 0)
        warn(at_, tag,
             fmt::format("{} of {} polygons dropped: a vertex is not finite", item.bad_polygons, item.facet_polygons));
      if (item.bad_normals > 0) warn(at_, tag, fmt::format("{} normals left out: not finite", item.bad_normals));
      builder_.add(item, layers, bytes_);
    }
    return true;
  }

  std::span<const std::byte> bytes_;
  ImportJob& job_;
  std::span<const RvmTextPlace> places_;
  RvmSceneBuilder builder_;
  std::uint64_t at_ = 0, depth_ = 0;
  bool ended_ = false;
};

}  // namespace

core::Expected<ImportReport> read_rvm(std::span<const std::byte> bytes, std::string_view file_name, core::Scene& scene,
                                      core::NodeId parent, const ImportOptions& options) {
  if (bytes.empty()) return core::fail(fmt::format("{}: the file is empty", file_name));
  // The file's matrices map to metres with z up already; its unit is that of the parameters.
  return run_import(file_name, scene, parent, options, {1.0, UpAxis::kZ}, [&](ImportJob& job) -> core::Expected<void> {
    std::string decoded;
    const auto text = without_utf16(job, bytes, decoded);
    if (!is_rvm_text(text)) return RvmWalk(bytes, job).run();
    const auto image = image_of_rvm_text(job, text);
    if (!image) return tl::unexpected(image.error());
    auto done = RvmWalk(image->bytes, job, image->places).run();
    job.report().bytes = bytes.size();
    return done;
  });
}

}  // namespace sightline::importers
