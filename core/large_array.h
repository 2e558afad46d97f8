// Vectors with one value or more per item.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <iterator>
#include <memory>
#include <type_traits>
#include <utility>

#include "sightline/core/api.h"

namespace sightline::core {

/// Allocates memory that starts at a cache line, so that a group of sixteen floats is one line and not two. From 2 MiB
/// on it asks for huge pages (Linux): queries and edits touch thousands of places far apart, and with small pages each
/// of them costs another miss. Throws std::bad_alloc.
SIGHTLINE_API void* allocate_lines(std::size_t bytes);
SIGHTLINE_API void release_lines(void* memory, std::size_t bytes);
/// Replaces `bytes` of memory from allocate_lines(), or null, by `more`, which begin with the first `used` of them;
/// never memory that spare_lines() has been called for. On Linux pages are moved instead of copied from 2 MiB on, in
/// some microseconds: an edit must not wait for a copy of a million items because there is one too many. Throws
/// std::bad_alloc, and then nothing has changed.
SIGHTLINE_API void* grow_lines(void* memory, std::size_t bytes, std::size_t used, std::size_t more);
/// Asks for small pages beyond the first `used` of `bytes` of memory from allocate_lines(). Linux then keeps it as two
/// mappings, which it cannot move as one. The first touch of a huge page clears two megabytes, which takes 0.1 ms, or 5
/// ms in a virtual machine, and a dozen arrays with a value per item come to their next page with the same item.
SIGHTLINE_API void spare_lines(void* memory, std::size_t used, std::size_t bytes);

/// A vector of values that may be copied byte by byte, with the interface of std::vector as far as it is used. Its
/// values may lie in memory that somebody else keeps, such as a mapped file, until the array grows out of it. A copy of
/// an array always has memory of its own.
template <class T>
class LargeArray {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

 public:
  using value_type = T;
  using iterator = T*;
  using const_iterator = const T*;

  LargeArray() = default;
  explicit LargeArray(std::size_t count, const T& value = T()) { resize(count, value); }
  template <std::input_iterator Iterator>
  LargeArray(Iterator first, Iterator last) {
    insert(end(), first, last);
  }
  LargeArray(const LargeArray& other) : LargeArray(other.begin(), other.end()) {}
  LargeArray(LargeArray&& other) noexcept { swap(other); }
  LargeArray& operator=(const LargeArray& other) {
    if (this != &other) assign(other.begin(), other.end());
    return *this;
  }
  LargeArray& operator=(LargeArray&& other) noexcept {
    LargeArray(std::move(other)).swap(*this);
    return *this;
  }
  ~LargeArray() { release(); }
  void swap(LargeArray& other) noexcept {
    std::swap(data_, other.data_), std::swap(size_, other.size_), std::swap(capacity_, other.capacity_);
    std::swap(keeper_, other.keeper_), std::swap(spared_, other.spared_);
  }

  /// An array of the `count` values at `values`, which `keeper` keeps there. They may be written to.
  static LargeArray kept(std::shared_ptr<const void> keeper, T* values, std::size_t count) {
    LargeArray array;
    array.data_ = values, array.size_ = array.capacity_ = count;
    array.keeper_ = std::move(keeper);
    return array;
  }
  /// Whether somebody else keeps the memory.
  bool is_kept() const { return keeper_ != nullptr; }

  std::size_t size() const { return size_; }
  std::size_t capacity() const { return capacity_; }
  bool empty() const { return size_ == 0; }
  T* data() { return data_; }
  const T* data() const { return data_; }
  iterator begin() { return data_; }
  iterator end() { return data_ + size_; }
  const_iterator begin() const { return data_; }
  const_iterator end() const { return data_ + size_; }
  T& operator[](std::size_t i) { return data_[i]; }
  const T& operator[](std::size_t i) const { return data_[i]; }
  T& front() { return data_[0]; }
  const T& front() const { return data_[0]; }
  T& back() { return data_[size_ - 1]; }
  const T& back() const { return data_[size_ - 1]; }

  void reserve(std::size_t capacity) {
    if (capacity > capacity_) grow(capacity);
  }
  /// Room beyond the values is for single ones that come later (spare_lines()).
  void spare_room() {
    if (keeper_) return;
    spare_lines(data_, size_ * sizeof(T), capacity_ * sizeof(T));
    spared_ = true;
  }
  void shrink_to_fit() {
    if (size_ < capacity_ && !keeper_) *this = LargeArray(begin(), end());
  }
  void resize(std::size_t count) { resize(count, T()); }
  void resize(std::size_t count, const T& value) {
    if (count > size_) {
      const T kept = value;  // it may lie in the array
      if (count > capacity_) grow(std::max(count, 2 * capacity_));
      std::uninitialized_fill(data_ + size_, data_ + count, kept);
    }
    size_ = count;
  }
  /// Leaves new values unset. For threads that each fill a part: the system clears new memory at the first touch, which
  /// takes longer than filling it.
  void resize_for_overwrite(std::size_t count) {
    if (count > capacity_) grow(std::max(count, 2 * capacity_));
    size_ = count;
  }
  void assign(std::size_t count, const T& value) {
    const T kept = value;
    clear();
    if (count > capacity_) *this = LargeArray();
    resize(count, kept);
  }
  template <std::input_iterator Iterator>
  void assign(Iterator first, Iterator last) {
    clear();
    insert(end(), first, last);
  }
  void clear() { size_ = 0; }
  void pop_back() { --size_; }
  void push_back(const T& value) { emplace_back(value); }
  template <class... Arguments>
  T& emplace_back(Arguments&&... arguments) {
    const T value{std::forward<Arguments>(arguments)...};  // made before growing: an argument may lie in the array
    if (size_ == capacity_) grow(std::max(kFirst, 2 * capacity_));
    return *std::construct_at(data_ + size_++, value);
  }
  /// At the end only.
  template <std::input_iterator Iterator>
  void insert(const_iterator, Iterator first, Iterator last) {
    if constexpr (std::random_access_iterator<Iterator>) {
      const auto count = std::size_t(last - first);
      if (size_ + count > capacity_) {
        // Copies before it releases: the range may lie in the array.
        LargeArray larger;
        larger.grow(std::max(size_ + count, 2 * capacity_));
        std::uninitialized_copy(begin(), end(), larger.data_);
        std::uninitialized_copy(first, last, larger.data_ + size_);
        larger.size_ = size_ + count;
        swap(larger);
      } else if (count > 0) {
        std::uninitialized_copy(first, last, data_ + size_);
        size_ += count;
      }
    } else {
      for (; first != last; ++first) push_back(*first);
    }
  }

  friend bool operator==(const LargeArray& a, const LargeArray& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
  }

 private:
  static constexpr std::size_t kFirst = 1;

  void grow(std::size_t capacity) {
    const std::size_t bytes = capacity * sizeof(T), used = size_ * sizeof(T);
    void* larger = nullptr;
    if (keeper_ || spared_) {
      larger = allocate_lines(bytes);
      if (used > 0) std::memcpy(larger, data_, used);
      release();
    } else {
      larger = grow_lines(data_, capacity_ * sizeof(T), used, bytes);
    }
    data_ = static_cast<T*>(larger), capacity_ = capacity;
  }
  void release() {
    if (!keeper_ && data_ != nullptr) release_lines(data_, capacity_ * sizeof(T));
    keeper_.reset();
    data_ = nullptr, capacity_ = 0, spared_ = false;
  }

  T* data_ = nullptr;
  std::size_t size_ = 0, capacity_ = 0;
  std::shared_ptr<const void> keeper_;  // null: the memory is the array's own
  bool spared_ = false;                 // spare_lines() has been called for it
};

}  // namespace sightline::core
