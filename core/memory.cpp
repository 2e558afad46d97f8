#include "sightline/core/memory.h"

#include "sightline/core/internal/scratch.h"

namespace sightline::core {
namespace {

struct ScratchList {
  std::mutex mutex;
  std::vector<ScratchObject*> objects;  // of all threads
};

/// Never destroyed: threads may end after static objects.
ScratchList& scratch_list() {
  static ScratchList& list = *new ScratchList;
  return list;
}

}  // namespace

ScratchObject::ScratchObject(Destroy destroy, Measure measure) : object(nullptr, destroy), measure_(measure) {
  ScratchList& list = scratch_list();
  const std::lock_guard lock(list.mutex);
  list.objects.push_back(this);
}

ScratchObject::~ScratchObject() {
  ScratchList& list = scratch_list();
  const std::lock_guard lock(list.mutex);
  std::erase(list.objects, this);
}

std::size_t scratch_bytes() {
  ScratchList& list = scratch_list();
  const std::lock_guard lock(list.mutex);
  std::size_t bytes = 0;
  for (ScratchObject* const each : list.objects) {
    if (const std::unique_lock idle(*each, std::try_to_lock); idle)
      each->bytes_ = each->object ? each->measure_(each->object.get()) : 0;
    bytes += each->bytes_;
  }
  return bytes;
}

void free_scratch() {
  ScratchList& list = scratch_list();
  const std::lock_guard lock(list.mutex);
  for (ScratchObject* const each : list.objects)
    if (const std::unique_lock idle(*each, std::try_to_lock); idle) {
      each->object.reset();
      each->bytes_ = 0;
    }
}

}  // namespace sightline::core
