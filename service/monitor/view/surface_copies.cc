#include "service/monitor/view/surface_copies.h"

namespace omni::monitor {

void SurfaceCopies::Update(const std::shared_ptr<const client::SurfaceReader>& reader) {
  if (reader != reader_) {
    reader_ = reader;
    copies_.clear();
    if (reader_ != nullptr) copies_.resize(reader_->object_count());
  }
  for (std::size_t i = 0; i < copies_.size(); ++i) reader_->Read(i, copies_[i]);
}

std::vector<std::shared_ptr<const std::string>> SurfaceCopies::NewsFor(std::uint32_t scene, SurfacesSent& sent) const {
  std::vector<std::shared_ptr<const std::string>> messages;
  if (reader_ == nullptr) return messages;
  if (sent.memory_generation != reader_->memory_generation() || sent.objects.size() != copies_.size()) {
    sent = {.memory_generation = reader_->memory_generation(),
            .objects = std::vector<SurfacesSent::Object>(copies_.size())};
  }
  for (std::size_t i = 0; i < copies_.size(); ++i) {
    const client::SurfaceCopy& copy = copies_[i];
    SurfacesSent::Object& known = sent.objects[i];
    if (copy.frame.t_ns == 0 || copy.frame.t_ns == known.t_ns) continue;
    const bool vertices = copy.frame.vertex_change != known.vertex_change;
    const bool triangles = copy.frame.triangle_change != known.triangle_change;
    const bool moves = (reader_->object(i).flags & protocol::kSurfaceMoved) != 0;
    known = {.vertex_change = copy.frame.vertex_change,
             .triangle_change = copy.frame.triangle_change,
             .t_ns = copy.frame.t_ns};
    if (!vertices && !triangles && !moves) continue;
    const bool shape = vertices || triangles;
    messages.push_back(std::make_shared<const std::string>(
        SurfaceMessage(scene, reader_->object(i).object, copy.frame,
                       shape ? std::span<const protocol::SurfacePoint>(copy.vertices_base_m)
                             : std::span<const protocol::SurfacePoint>(),
                       triangles ? std::span<const protocol::SurfaceTriangle>(copy.triangles)
                                 : std::span<const protocol::SurfaceTriangle>())));
  }
  return messages;
}

std::vector<ViewPart> SurfaceCopies::Parts() const {
  std::vector<ViewPart> parts;
  if (reader_ == nullptr) return parts;
  for (std::size_t i = 0; i < reader_->object_count(); ++i) {
    const protocol::SurfacePart& part = reader_->object(i);
    parts.push_back({.name = part.name, .object = static_cast<std::int32_t>(part.object), .material = 0, .shape = {}});
  }
  return parts;
}

}  // namespace omni::monitor
