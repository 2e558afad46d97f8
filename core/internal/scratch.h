// Internal: scratch buffers of functions that any thread may call (memory.h).
//
//   struct FilterBuffers {
//     std::vector<core::Slot> slots;
//     std::size_t memory_bytes() const { return core::bytes_of(slots); }
//   };
//   const core::Scratch<FilterBuffers> scratch;
//   scratch->slots.clear();
//
// A thread has one object of each type and keeps it until it ends or core::free_scratch() frees it. So a function finds
// what its last call on this thread has left there, or a new object. It must not be called, on the same thread, by what
// it calls while it holds the object. Objects of one thread, such as a culler that is not const, keep buffers as
// members instead.
#pragma once

#include <atomic>
#include <cassert>
#include <cstddef>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "sightline/core/internal/platform/threads.h"
#include "sightline/core/large_array.h"
#include "sightline/core/memory.h"
#include "sightline/core/visible_set.h"

namespace sightline::core {

template <class T>
std::size_t memory_of(const std::vector<T>& array) {
  return array.capacity() * sizeof(T);
}
template <class T>
std::size_t memory_of(const LargeArray<T>& array) {
  return array.capacity() * sizeof(T);
}
inline std::size_t memory_of(const VisibleSet& set) {
  return memory_of(set.ranges) + memory_of(set.single_slots);
}
template <class T>
requires requires(const T& object) {
  object.memory_bytes();
}
std::size_t memory_of(const T& object) {
  return object.memory_bytes();
}

/// Bytes that the objects have allocated.
template <class... T>
std::size_t bytes_of(const T&... objects) {
  return (memory_of(objects) + ... + std::size_t(0));
}

/// One thread's object of one type, known to memory.h. Its thread, scratch_bytes() or free_scratch() holds the lock.
class ScratchObject {
 public:
  using Destroy = void (*)(void* object);
  using Measure = std::size_t (*)(const void* object);

  ScratchObject(Destroy destroy, Measure measure);
  ~ScratchObject();
  ScratchObject(const ScratchObject&) = delete;
  ScratchObject& operator=(const ScratchObject&) = delete;

  // As of a mutex, which would cost twice as much in each call. Others than the thread hold it for microseconds.
  void lock() {
    while (!try_lock()) std::this_thread::yield();
  }
  bool try_lock() { return !locked_.test_and_set(std::memory_order_acquire); }
  void unlock() { locked_.clear(std::memory_order_release); }

  std::unique_ptr<void, Destroy> object;  ///< null before the first use, and after free_scratch()
  bool in_use = false;                    ///< by its thread, which alone reads and writes this

 private:
  friend std::size_t scratch_bytes();
  friend void free_scratch();

  std::atomic_flag locked_;
  Measure measure_;
  std::size_t bytes_ = 0;  // when it was measured last; under the lock of the list of all objects
};

/// The calling thread's object of a type, for as long as this exists.
template <class T>
class Scratch {
 public:
  Scratch() : lock_(of_thread()) {
    ScratchObject& kept = *lock_.mutex();
    if (!kept.object) kept.object.reset(new T);
    object_ = static_cast<T*>(kept.object.get());
    kept.in_use = true;
  }
  ~Scratch() { lock_.mutex()->in_use = false; }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  T* operator->() const { return object_; }
  T& operator*() const { return *object_; }

 private:
  static ScratchObject& of_thread() {
    thread_local ScratchObject* kept = nullptr;
    if (!kept) {
      kept = new ScratchObject(
          [](void* object) { delete static_cast<T*>(object); },
          [](const void* object) { return sizeof(T) + static_cast<const T*>(object)->memory_bytes(); });
      platform::at_end_of_thread([](void* object) { delete static_cast<ScratchObject*>(object); }, kept);
    }
    assert(!kept->in_use);
    return *kept;
  }

  std::unique_lock<ScratchObject> lock_;
  T* object_;
};

}  // namespace sightline::core
