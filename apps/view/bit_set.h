// A set of indices below a size, one bit each.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sightline::apps {

class BitSet {
 public:
  static constexpr std::size_t kWordBits = 64;

  /// A set of none, or all, of the indices below `size`.
  explicit BitSet(std::size_t size = 0, bool all = false)
      : size_(size), words_((size + kWordBits - 1) / kWordBits, all ? ~std::uint64_t(0) : 0) {
    if (all && size % kWordBits != 0) words_.back() = below(size);
  }

  std::size_t size() const { return size_; }
  bool test(std::size_t i) const { return (words_[i / kWordBits] >> (i % kWordBits) & 1) != 0; }
  void set(std::size_t i) { words_[i / kWordBits] |= bit(i); }
  void clear(std::size_t i) { words_[i / kWordBits] &= ~bit(i); }

  /// The first member from `from` on; size() if there is none.
  std::size_t next(std::size_t from) const {
    std::size_t w = from / kWordBits;
    if (w >= words_.size()) return size_;
    std::uint64_t word = words_[w] & ~below(from);
    while (word == 0) {
      if (++w == words_.size()) return size_;
      word = words_[w];
    }
    return w * kWordBits + std::size_t(std::countr_zero(word));
  }

  /// Calls visit(i) for each member in rising order.
  template <class Visit>
  void for_each(Visit&& visit) const {
    for (std::size_t w = 0; w < words_.size(); ++w)
      for (std::uint64_t word = words_[w]; word != 0; word &= word - 1)
        visit(w * kWordBits + std::size_t(std::countr_zero(word)));
  }

  /// Adds the members of `other`, of the same size, from `first` to below `last`.
  void add(const BitSet& other, std::size_t first, std::size_t last) {
    for_words(first, last, [&](std::size_t w, std::uint64_t mask) { words_[w] |= other.words_[w] & mask; });
  }
  void add(const BitSet& other) { add(other, 0, size_); }
  /// Removes the members from `first` to below `last`.
  void remove(std::size_t first, std::size_t last) {
    for_words(first, last, [&](std::size_t w, std::uint64_t mask) { words_[w] &= ~mask; });
  }

  /// Number of members.
  std::size_t count() const {
    std::size_t n = 0;
    for (const std::uint64_t word : words_) n += std::size_t(std::popcount(word));
    return n;
  }

  /// Word w holds the indices from w * kWordBits on, the first one in its lowest bit.
  std::size_t word_count() const { return words_.size(); }
  std::uint64_t word(std::size_t w) const { return words_[w]; }
  /// The bits of index i's word that stand for lower indices.
  static std::uint64_t below(std::size_t i) { return bit(i) - 1; }

 private:
  static std::uint64_t bit(std::size_t i) { return std::uint64_t(1) << (i % kWordBits); }

  template <class Visit>
  void for_words(std::size_t first, std::size_t last, Visit&& visit) {
    if (first >= last) return;
    const std::size_t first_word = first / kWordBits, last_word = (last - 1) / kWordBits;
    for (std::size_t w = first_word; w <= last_word; ++w) {
      std::uint64_t mask = ~std::uint64_t(0);
      if (w == first_word) mask &= ~below(first);
      if (w == last_word) mask &= below(last - 1) | bit(last - 1);
      visit(w, mask);
    }
  }

  std::size_t size_;
  std::vector<std::uint64_t> words_;
};

}  // namespace sightline::apps
