// The surfaces of omnid's surface memory as they are now, and which page has seen which of them.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "service/client/surface_reader.h"
#include "service/monitor/page/page_text.h"

namespace omni::monitor {

// What one page has been sent of each object.
struct SurfacesSent {
  std::uint64_t memory_generation = 0;
  struct Object {
    std::uint64_t vertex_change = 0, triangle_change = 0;
    std::int64_t t_ns = 0;
  };
  std::vector<Object> objects;
};

class SurfaceCopies {
 public:
  // Reads what is new. `reader` may be null: nothing changes.
  void Update(const std::shared_ptr<const client::SurfaceReader>& reader);

  // Of which scene of omnid these are; 0: there are none.
  std::uint64_t scene_generation() const { return reader_ == nullptr ? 0 : reader_->scene_generation(); }

  // Messages with what `sent` does not have yet; updates `sent`. `scene`: number of the page's scene.
  std::vector<std::shared_ptr<const std::string>> NewsFor(std::uint32_t scene, SurfacesSent& sent) const;

  // Parts without a shape of their own, for a scene whose file is not at hand.
  std::vector<ViewPart> Parts() const;

 private:
  std::shared_ptr<const client::SurfaceReader> reader_;
  std::vector<client::SurfaceCopy> copies_;
};

}  // namespace omni::monitor
