#include "sightline/apps/mpi/composition.h"

#include <cassert>

namespace sightline::apps {

void compose(std::span<const Fragment> more, std::span<Fragment> into) {
  assert(more.size() == into.size());
  for (std::size_t i = 0; i < into.size(); ++i)
    if (hides(more[i], into[i])) into[i] = more[i];
}

}  // namespace sightline::apps
