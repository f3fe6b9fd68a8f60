// What the bench times: an engine that is built over a body and queried once per tick.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "service/haptics/haptics.h"
#include "tests/bench/collision/body.h"

namespace omni::collision {

struct BuildCost {
  double build_ms = 0;
  double tree_bytes = 0;  // beyond mesh and adjacency
};

class Engine {
 public:
  Engine() = default;
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;
  virtual ~Engine() = default;

  virtual const char* name() const = 0;
  virtual BuildCost Build(const Body& body) = 0;
  // A new path begins.
  virtual void Start(const Vec3& tip) = 0;
  // Moves the tip. Returns the distance to the surface, or a negative number if the engine does not compute it.
  virtual double Tick(const Vec3& tip) = 0;
};

// Nearest point of a triangle in float, the callback of the engines that need one. Squared distance.
float NearestInFloat(const float (&a)[3], const float (&b)[3], const float (&c)[3], const float (&p)[3]);

// nullptr: not in this build.
std::unique_ptr<Engine> MakeEmbree(bool warm);
std::unique_ptr<Engine> MakeBullet();
std::unique_ptr<Engine> MakeFcl();
std::unique_ptr<Engine> MakeCgal();

// Ours. `scene` outlives the engine.
enum class OmniKind { kProxy, kContact, kClosest, kClosestCold };
std::unique_ptr<Engine> MakeOmni(OmniKind kind, const haptics::Scene& scene, const BuildCost& cost);

haptics::SceneInput SceneOf(const Body& body);
// A tip without friction or limits: the contact alone.
haptics::Config PlainConfig();
haptics::Input PlainInput();

}  // namespace omni::collision
