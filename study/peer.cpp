#include "sightline/study/peer.h"

#include <vector>

namespace sightline::study {

std::span<const Peer> peers() {
  static const std::vector<Peer> built{
#ifdef SIGHTLINE_STUDY_HAS_OSG
      {"OpenSceneGraph", make_osg},
#endif
#ifdef SIGHTLINE_STUDY_HAS_OCCT
      {"Open CASCADE", make_occt},
#endif
#ifdef SIGHTLINE_STUDY_HAS_VTK
      {"VTK", make_vtk},
#endif
  };
  return built;
}

}  // namespace sightline::study
