#include "service/scene/gltf/view_bytes.h"

#include <algorithm>

#include "service/scene/gltf/json_reading.h"

namespace omni::scene {
namespace {

constexpr std::uint64_t kMaxPackedBytes = 1ull << 30;
// Accessors may share bytes, as those of interleaved vertices do: each attribute reaches over all of them. A file whose
// accessors share more than a handful of attributes can would be far larger in memory than on disk.
constexpr std::uint64_t kMaxShares = 6;
// Of compressed meshes; those of exporters take a fourth to a thirtieth, regular ones far less: a few are always taken.
constexpr std::uint64_t kMaxExpansion = 64;
constexpr std::uint64_t kAlwaysDecoded = 64ull << 20;

std::size_t AlignedUp(std::size_t size) { return (size + 3) / 4 * 4; }

}  // namespace

ViewBytes::Range ViewBytes::RangeOf(std::uint32_t view) const {
  const Json& json = ElementOf(file_.root(), "bufferViews", view);
  const std::string pointer = JoinPointer("/bufferViews", view);
  const auto buffer = ReadIndex(json, pointer, "buffer", CountOf(file_.root(), "buffers"));
  if (!buffer) throw LoadError(JoinPointer(pointer, "buffer"), "is missing");
  return {*buffer, ReadInteger(json, pointer, "byteOffset", kMaxViewOffset, 0),
          ReadInteger(json, pointer, "byteLength", kMaxViewOffset, std::nullopt)};
}

std::size_t ViewBytes::Add(std::uint32_t view, const std::string& pointer, std::uint64_t offset, std::uint64_t bytes) {
  Range range = RangeOf(view);
  const auto compressed = MeshoptOf(file_.root(), view);
  const bool decode = compressed && !HasFallback(range.buffer);
  const std::uint64_t length = decode ? compressed->decoded_bytes() : range.bytes;
  if (!(offset <= length && bytes <= length - offset)) {
    throw LoadError(pointer, "needs " + std::to_string(bytes) + " bytes at " + std::to_string(offset) + " of " +
                                 JoinPointer("/bufferViews", view) + ", which has " + std::to_string(length) +
                                 "; count, byteOffset or byteStride is wrong");
  }
  if (decode) return DecodedView(*compressed, view) + static_cast<std::size_t>(offset);
  range = {range.buffer, range.offset + offset, bytes};
  if (const auto found = places_.find(range); found != places_.end()) return found->second;
  return places_[range] = Read(range);
}

std::size_t ViewBytes::Read(const Range& range) {
  const std::size_t at = AlignedUp(bytes_.size());
  // Reads the last byte first: whether the file has these bytes is known before memory is allocated.
  unsigned char last = 0;
  if (range.bytes > 0) file_.ReadBuffer(range.buffer, range.offset + range.bytes - 1, &last, 1);
  const std::uint64_t most = std::min(kMaxPackedBytes, kMaxShares * file_.stored_bytes());
  if (range.bytes > most - std::min<std::uint64_t>(at - std::min<std::uint64_t>(at, decoded_bytes_), most)) {
    const std::string why = most == kMaxPackedBytes
                                ? "the limit; simplify the model"
                                : "six times what its files hold: accessors overlap, export it again";
    throw LoadError("/bufferViews", "the touched meshes need more than " + std::to_string(most) + " bytes, " + why);
  }
  bytes_.resize(at + static_cast<std::size_t>(range.bytes));
  file_.ReadBuffer(range.buffer, range.offset, bytes_.data() + at, static_cast<std::size_t>(range.bytes));
  fresh_bytes_ += range.bytes;
  return at;
}

std::vector<unsigned char> ViewBytes::ReadWhole(const Range& range) {
  unsigned char last = 0;
  if (range.bytes > 0) file_.ReadBuffer(range.buffer, range.offset + range.bytes - 1, &last, 1);
  compressed_bytes_ += range.bytes;
  if (const std::uint64_t most = kMaxShares * file_.stored_bytes(); compressed_bytes_ > most) {
    throw LoadError("/bufferViews", "the touched meshes have more than " + std::to_string(most) +
                                        " compressed bytes, six times what its files hold: views overlap, export it "
                                        "again");
  }
  std::vector<unsigned char> stored(static_cast<std::size_t>(range.bytes));
  file_.ReadBuffer(range.buffer, range.offset, stored.data(), stored.size());
  fresh_bytes_ += range.bytes;
  return stored;
}

std::vector<unsigned char> ViewBytes::ReadStored(std::uint32_t view) { return ReadWhole(RangeOf(view)); }

std::uint64_t ViewBytes::CheckRoom(const std::string& pointer, std::uint64_t bytes) const {
  const std::uint64_t most = std::clamp(kMaxExpansion * file_.stored_bytes(), kAlwaysDecoded, kMaxPackedBytes);
  const std::uint64_t room = most - std::min(decoded_bytes_, most);
  if (bytes > room) {
    const std::string why = most == kMaxPackedBytes ? "the limit; simplify the model"
                                                    : "64 MiB and 64 times what its files hold; export it again";
    throw LoadError(pointer, "with those before, is decoded to more than " + std::to_string(most) + " bytes, " + why);
  }
  return room;
}

std::size_t ViewBytes::ReserveRoom(const std::string& pointer, std::uint64_t bytes) {
  CheckRoom(pointer, bytes);
  const std::size_t at = AlignedUp(bytes_.size());
  bytes_.resize(at + static_cast<std::size_t>(bytes));
  decoded_bytes_ += bytes;
  return at;
}

std::size_t ViewBytes::DecodedView(const MeshoptView& view, std::uint32_t number) {
  if (const auto found = decoded_places_.find(number); found != decoded_places_.end()) return found->second;
  const std::vector<unsigned char> stored = ReadWhole({view.buffer, view.offset, view.length});
  const std::size_t at = ReserveRoom(view.pointer, view.decoded_bytes());
  DecodeMeshopt(view, stored, {bytes_.data() + at, static_cast<std::size_t>(view.decoded_bytes())});
  return decoded_places_[number] = at;
}

// The buffer of a compressed view has the same bytes uncompressed, for readers without the extension; or none.
bool ViewBytes::HasFallback(std::uint32_t buffer) {
  const auto [known, fresh] = fallbacks_.try_emplace(buffer, false);
  if (fresh) known->second = file_.HasBuffer(buffer);
  return known->second;
}

}  // namespace omni::scene
