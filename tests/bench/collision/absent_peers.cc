// Engines whose library was not found at configure time.
#include "tests/bench/collision/engine.h"

namespace omni::collision {

#ifndef OMNI_HAVE_EMBREE
std::unique_ptr<Engine> MakeEmbree(bool /*warm*/) { return nullptr; }
#endif
#ifndef OMNI_HAVE_BULLET
std::unique_ptr<Engine> MakeBullet() { return nullptr; }
#endif
#ifndef OMNI_HAVE_FCL
std::unique_ptr<Engine> MakeFcl() { return nullptr; }
#endif
#ifndef OMNI_HAVE_CGAL
std::unique_ptr<Engine> MakeCgal() { return nullptr; }
#endif

}  // namespace omni::collision
