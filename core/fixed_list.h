// A list of at most N values in place, without memory of its own.
#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <initializer_list>

namespace sightline::core {

/// As std::vector, for values that are cheap to make. More than N values break the contract.
template <class T, std::size_t N>
class FixedList {
 public:
  FixedList() = default;
  FixedList(std::initializer_list<T> values) {
    for (const T& value : values) push_back(value);
  }

  void push_back(const T& value) {
    assert(size_ < N);
    values_[size_++] = value;
  }
  void clear() { size_ = 0; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const T* data() const { return values_.data(); }
  const T* begin() const { return values_.data(); }
  const T* end() const { return values_.data() + size_; }
  const T& operator[](std::size_t i) const { return values_[i]; }

 private:
  std::array<T, N> values_;
  std::size_t size_ = 0;
};

}  // namespace sightline::core
