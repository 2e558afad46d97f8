// Internal: objects that jobs on several threads borrow, one each.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

namespace sightline::culling {

/// Keeps the objects, and so their memory, from one use to the next.
template <class T>
class ObjectPool {
 public:
  /// Afterwards none has been lent.
  void begin() {
    begun_ = 0;
    idle_.clear();
  }
  /// An idle object. One that has not been lent since begin() is first given to `prepare`.
  template <class Prepare>
  T& take(const Prepare& prepare) {
    const std::lock_guard lock(mutex_);
    if (!idle_.empty()) {
      T& object = *idle_.back();
      idle_.pop_back();
      return object;
    }
    if (begun_ == objects_.size()) objects_.push_back(std::make_unique<T>());
    T& object = *objects_[begun_++];
    prepare(object);
    return object;
  }
  void give_back(T& object) {
    const std::lock_guard lock(mutex_);
    idle_.push_back(&object);
  }
  /// The objects lent since begin(). Must not be called while jobs run.
  std::span<const std::unique_ptr<T>> used() const { return std::span(objects_).first(begun_); }
  /// Bytes of all objects. Not while jobs run.
  std::size_t memory_bytes() const {
    std::size_t bytes = (objects_.capacity() + idle_.capacity()) * sizeof(T*);
    for (const auto& object : objects_) bytes += sizeof(T) + object->memory_bytes();
    return bytes;
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<T>> objects_;
  std::vector<T*> idle_;
  std::size_t begun_ = 0;
};

}  // namespace sightline::culling
