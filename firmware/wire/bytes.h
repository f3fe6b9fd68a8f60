// Little-endian fields in sequence. A cursor never runs past its end: it sets `ok` to false and reads zeros.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace omni::wire {

class ByteWriter {
 public:
  ByteWriter(std::uint8_t* data, std::size_t capacity) noexcept : data_(data), capacity_(capacity) {}

  void U8(std::uint8_t value) noexcept { Put(value, 1); }
  void U16(std::uint16_t value) noexcept { Put(value, 2); }
  void U32(std::uint32_t value) noexcept { Put(value, 4); }
  void U64(std::uint64_t value) noexcept { Put(value, 8); }
  void I16(std::int16_t value) noexcept { U16(static_cast<std::uint16_t>(value)); }
  void F32(float value) noexcept {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    U32(bits);
  }

  bool ok() const noexcept { return ok_; }
  std::size_t size() const noexcept { return size_; }

 private:
  void Put(std::uint64_t value, std::size_t width) noexcept {
    if (!ok_ || capacity_ - size_ < width) {
      ok_ = false;
      return;
    }
    for (std::size_t i = 0; i < width; ++i) data_[size_++] = static_cast<std::uint8_t>(value >> (8 * i));
  }

  std::uint8_t* data_;
  std::size_t capacity_;
  std::size_t size_ = 0;
  bool ok_ = true;
};

class ByteReader {
 public:
  ByteReader(const std::uint8_t* data, std::size_t size) noexcept : data_(data), size_(size) {}

  std::uint8_t U8() noexcept { return static_cast<std::uint8_t>(Get(1)); }
  std::uint16_t U16() noexcept { return static_cast<std::uint16_t>(Get(2)); }
  std::uint32_t U32() noexcept { return static_cast<std::uint32_t>(Get(4)); }
  std::uint64_t U64() noexcept { return Get(8); }
  std::int16_t I16() noexcept { return static_cast<std::int16_t>(U16()); }
  float F32() noexcept {
    const std::uint32_t bits = U32();
    float value = 0;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }

  bool ok() const noexcept { return ok_; }

 private:
  std::uint64_t Get(std::size_t width) noexcept {
    if (!ok_ || size_ - at_ < width) {
      ok_ = false;
      return 0;
    }
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < width; ++i) value |= static_cast<std::uint64_t>(data_[at_++]) << (8 * i);
    return value;
  }

  const std::uint8_t* data_;
  std::size_t size_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

}  // namespace omni::wire
