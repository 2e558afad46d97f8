#include "sightline/apps/view/name_search.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstring>
#include <functional>
#include <thread>
#include <utility>

#include "sightline/apps/common/tree_walk.h"
#include "sightline/apps/view/regular_expression.h"
#include "sightline/core/internal/ascii_case.h"
#include "sightline/core/thread_pool.h"
#include "sightline/importers/import.h"

namespace sightline::apps {
namespace {

using core::kNone;
using core::NodeId;

constexpr std::size_t kChunkBytes = 128 << 10, kChunkTexts = 4096;
constexpr std::size_t kMostThreads = 8;
constexpr std::size_t kQuoted = 60;  // bytes of a text in a message

}  // namespace

// --- the index -------------------------------------------------------------------------------------------------------

/// Gathers a field's texts with the nodes where they occur.
class NameIndex::FieldBuilder {
 public:
  void add(std::string_view text, std::uint32_t node) { occurrences_.push_back({text_of(text), node}); }

  Field finish() && {
    // A counting sort by text. Within a text, nodes stay in tree order.
    field_.first_node.assign(field_.size() + 1, 0);
    for (const auto& [text, node] : occurrences_) ++field_.first_node[text + 1];
    for (std::size_t i = 1; i <= field_.size(); ++i) field_.first_node[i] += field_.first_node[i - 1];
    std::vector<std::uint32_t> next(field_.first_node.begin(), field_.first_node.end() - 1);
    field_.nodes.resize(occurrences_.size());
    for (const auto& [text, node] : occurrences_) field_.nodes[next[text]++] = node;
    field_.bytes.shrink_to_fit();
    field_.start.shrink_to_fit();
    return std::move(field_);
  }

 private:
  struct Occurrence {
    std::uint32_t text, node;
  };

  /// The number of a text, which is added unless it is there. The table is a hash table with open addressing.
  std::uint32_t text_of(std::string_view text) {
    if (2 * field_.size() >= table_.size()) enlarge_table();
    const std::size_t begin = field_.bytes.size();
    field_.bytes.resize(begin + text.size());
    std::transform(text.begin(), text.end(), field_.bytes.begin() + std::ptrdiff_t(begin),
                   [](char c) { return core::lower_case(c); });
    const std::string_view added = std::string_view(field_.bytes).substr(begin);
    std::uint32_t& place = find(added);
    if (place != kNone) {
      field_.bytes.resize(begin);
    } else {
      place = std::uint32_t(field_.size());
      field_.start.push_back(field_.bytes.size());
    }
    return place;
  }
  /// The place of an equal text in the table, or the free one for it.
  std::uint32_t& find(std::string_view text) {
    std::size_t at = std::hash<std::string_view>()(text) & (table_.size() - 1);
    while (table_[at] != kNone && field_.text(table_[at]) != text) at = (at + 1) & (table_.size() - 1);
    return table_[at];
  }
  void enlarge_table() {
    table_.assign(std::max<std::size_t>(16, 4 * table_.size()), kNone);
    for (std::size_t i = 0; i < field_.size(); ++i) find(field_.text(i)) = std::uint32_t(i);
  }

  Field field_;
  std::vector<std::uint32_t> table_;  // its size is a power of two
  std::vector<Occurrence> occurrences_;
};

NameIndex::NameIndex(const core::Scene& scene) {
  std::vector<FieldBuilder> builders(1);
  nodes_.reserve(scene.node_count());
  const auto builder_of = [&](std::string_view key) -> FieldBuilder& {
    const auto [known, added] = field_of_key_.try_emplace(core::lower_case(key), std::uint32_t(builders.size()));
    if (added) builders.emplace_back();
    return builders[known->second];
  };
  walk(
      scene,
      [&](NodeId node) {
        const auto number = std::uint32_t(nodes_.size());
        nodes_.push_back(node);
        builders[0].add(scene.name(node), number);
        for (const auto& [key, value] : scene.attributes(node)) builder_of(key).add(value, number);
      },
      [](NodeId) {});

  fields_.reserve(builders.size());
  for (FieldBuilder& builder : builders) {
    const auto f = std::uint32_t(fields_.size());
    const Field& field = fields_.emplace_back(std::move(builder).finish());
    first_chunk_.push_back(chunks_.size());
    for (std::size_t first = 0, last; first < field.size(); first = last) {
      for (last = first + 1; last < field.size() && last < first + kChunkTexts &&
                             field.start[last + 1] - field.start[first] <= kChunkBytes;)
        ++last;
      chunks_.push_back({f, std::uint32_t(first), std::uint32_t(last)});
    }
    for (const char c : field.bytes) ++frequency_[static_cast<unsigned char>(c)];
  }
  first_chunk_.push_back(chunks_.size());
}

std::size_t NameIndex::memory_bytes() const {
  std::size_t bytes = nodes_.capacity() * sizeof(NodeId) + chunks_.capacity() * sizeof(Chunk);
  for (const Field& field : fields_)
    bytes += sizeof(Field) + field.bytes.capacity() + field.start.capacity() * sizeof(std::size_t) +
             (field.first_node.capacity() + field.nodes.capacity()) * sizeof(std::uint32_t);
  return bytes;
}

// --- texts -----------------------------------------------------------------------------------------------------------

/// A lower-case text to find, and its two bytes that are rarest in the index.
struct NameIndex::Needle {
  std::string text;
  std::size_t rare = 0, rare2 = 0;
};

NameIndex::Needle NameIndex::needle(std::string text) const {
  Needle needle{std::move(text)};
  const auto frequency = [&](std::size_t i) { return frequency_[static_cast<unsigned char>(needle.text[i])]; };
  for (std::size_t i = 1; i < needle.text.size(); ++i)
    if (frequency(i) < frequency(needle.rare)) needle.rare = i;
  needle.rare2 = needle.rare == 0 ? needle.text.size() - 1 : 0;
  for (std::size_t i = 0; i < needle.text.size(); ++i)
    if (i != needle.rare && frequency(i) < frequency(needle.rare2)) needle.rare2 = i;
  return needle;
}

void NameIndex::mark(const Field& field, std::size_t text, BitSet& found) {
  for (std::uint32_t i = field.first_node[text]; i < field.first_node[text + 1]; ++i) found.set(field.nodes[i]);
}

namespace {

/// Calls candidate(i) for all i from `first` to below `last`, in rising order, where bytes[i + a] and bytes[i + b] are
/// as in `text`, which begins at i. 64 places at a time, in a form that compilers turn into vector instructions.
template <class Candidate>
void for_candidates(const char* bytes, std::size_t first, std::size_t last, std::string_view text,
                    std::pair<std::size_t, std::size_t> rare, Candidate&& candidate) {
  const auto [a, b] = rare;
  const char x = text[a], y = text[b];
  constexpr std::size_t kBlock = 64, kWord = sizeof(std::uint64_t);
  static_assert(std::endian::native == std::endian::little, "the lowest byte of a word is the first in memory");
  std::size_t i = first;
  for (; i + kBlock <= last; i += kBlock) {
    const char *const at_a = bytes + i + a, *const at_b = bytes + i + b;
    unsigned char equal[kBlock];
    for (std::size_t k = 0; k < kBlock; ++k) equal[k] = static_cast<unsigned char>((at_a[k] == x) & (at_b[k] == y));
    std::uint64_t words[kBlock / kWord], any = 0;
    std::memcpy(words, equal, kBlock);
    for (const std::uint64_t word : words) any |= word;
    if (any == 0) continue;
    for (std::size_t w = 0; w < kBlock / kWord; ++w)
      for (std::uint64_t word = words[w]; word != 0; word &= word - 1)
        candidate(i + w * kWord + std::size_t(std::countr_zero(word)) / 8);
  }
  for (; i < last; ++i)
    if (bytes[i + a] == x && bytes[i + b] == y) candidate(i);
}

/// The last of the rising values that is not above x, from the one at `from` on, which is not. Doubling steps: near
/// values are found at once.
std::size_t last_not_above(const std::vector<std::size_t>& values, std::size_t from, std::size_t x) {
  std::size_t step = 1;
  while (from + step < values.size() && values[from + step] <= x) {
    from += step;
    step *= 2;
  }
  for (; step > 0; step /= 2)
    if (from + step < values.size() && values[from + step] <= x) from += step;
  return from;
}

}  // namespace

void NameIndex::scan(const Field& field, const Chunk& chunk, const Needle& needle, BitSet& found) {
  const std::string& text = needle.text;
  if (text.empty()) {
    for (std::size_t i = chunk.first; i < chunk.last; ++i) mark(field, i, found);
    return;
  }
  const std::size_t begin = field.start[chunk.first], end = field.start[chunk.last];
  if (end - begin < text.size()) return;
  const char* const bytes = field.bytes.data();
  std::size_t here = chunk.first, done = begin;  // the texts before `done` need no more hits
  for_candidates(bytes, begin, end - text.size() + 1, text, {needle.rare, needle.rare2}, [&](std::size_t i) {
    if (i < done || std::memcmp(bytes + i, text.data(), text.size()) != 0) return;
    here = last_not_above(field.start, here, i);
    const std::size_t text_end = field.start[here + 1];
    if (i + text.size() > text_end) return;  // it begins in one text and ends in another
    mark(field, here, found);
    done = text_end;
  });
}

// --- queries ---------------------------------------------------------------------------------------------------------

NameIndex::Target NameIndex::target_of(std::string_view query) const {
  for (std::size_t colon = query.size(); (colon = query.substr(0, colon).rfind(':')) != query.npos && colon > 0;)
    if (const auto known = field_of_key_.find(core::lower_case(query.substr(0, colon))); known != field_of_key_.end())
      return {first_chunk_[known->second], first_chunk_[known->second + 1], query.substr(colon + 1)};
  return {0, chunks_.size(), query};
}

std::optional<core::NodeCondition> NameIndex::condition_of(std::string_view query) const {
  const std::string_view text = target_of(query).text;
  if (text.size() == query.size()) return std::nullopt;
  return core::NodeCondition{std::string(query.substr(0, query.size() - text.size() - 1)), std::string(text)};
}

/// Scans all chunks of the target on several threads. Each has a scan of its own from make_scan(): a function of a
/// field, a chunk and the set of nodes found, which returns an error or none.
template <class MakeScan>
core::Expected<BitSet> NameIndex::scan_all(const Target& target, const std::stop_token& stop,
                                           const MakeScan& make_scan) const {
  struct Worker {
    decltype(make_scan()) scan;
    BitSet found;
    core::Expected<void> result;
  };
  const std::size_t chunks = target.last_chunk - target.first_chunk;
  const std::size_t threads =
      std::clamp<std::size_t>(std::min<std::size_t>(std::thread::hardware_concurrency(), chunks), 1, kMostThreads);
  std::vector<Worker> workers;
  for (std::size_t i = 0; i < threads; ++i) workers.push_back({make_scan(), BitSet(nodes_.size()), {}});
  std::atomic<std::size_t> next = target.first_chunk;
  const auto work = [&](Worker& worker) {
    for (std::size_t i; (i = next++) < target.last_chunk && !stop.stop_requested();) {
      const Chunk& chunk = chunks_[i];
      worker.result = worker.scan(fields_[chunk.field], chunk, worker.found);
      if (!worker.result) next = target.last_chunk;  // ends the others
    }
  };
  core::ThreadPool(int(threads)).run_at_once(std::uint32_t(threads), [&](std::uint32_t i) { work(workers[i]); });
  if (stop.stop_requested()) return core::fail(std::string(importers::kCancelled));
  for (Worker& worker : workers) {
    if (!worker.result) return tl::unexpected(worker.result.error());
    if (&worker != &workers[0]) workers[0].found.add(worker.found);
  }
  return std::move(workers[0].found);
}

core::Expected<NameMatches> NameIndex::find(const NameQuery& query, std::size_t limit, std::stop_token stop) const {
  const Target target = target_of(query.text);
  core::Expected<BitSet> found;
  if (query.regular_expression) {
    const auto expression = RegularExpression::compile(target.text);
    if (!expression) return tl::unexpected(expression.error());
    found = scan_all(target, stop, [&] {
      return [&stop, matcher = RegularExpression::Matcher(*expression)](const Field& field, const Chunk& chunk,
                                                                        BitSet& nodes) mutable -> core::Expected<void> {
        using Answer = RegularExpression::Matcher::Answer;
        for (std::size_t i = chunk.first; i < chunk.last && !stop.stop_requested(); ++i) {
          const Answer answer = matcher.matches(field.text(i));
          if (answer == Answer::kTooHard)
            return core::fail("regular expression: takes too many steps on a text that begins \"" +
                              std::string(field.text(i).substr(0, kQuoted)) + "\"");
          if (answer == Answer::kYes) mark(field, i, nodes);
        }
        return {};
      };
    });
  } else {
    const Needle wanted = needle(core::lower_case(target.text));
    found = scan_all(target, stop, [&] {
      return [&](const Field& field, const Chunk& chunk, BitSet& nodes) -> core::Expected<void> {
        scan(field, chunk, wanted, nodes);
        return {};
      };
    });
  }
  if (!found) return tl::unexpected(found.error());

  NameMatches matches;
  matches.count = found->count();
  matches.nodes.reserve(std::min(limit, matches.count));
  for (std::size_t i = found->next(0); i < found->size() && matches.nodes.size() < limit; i = found->next(i + 1))
    matches.nodes.push_back(nodes_[i]);
  return matches;
}

}  // namespace sightline::apps
