#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tandem {

enum class PlyNumberKind : std::uint8_t {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kFloat,
  kDouble
};

struct PlyProperty {
  std::string name;
  PlyNumberKind kind = PlyNumberKind::kFloat;
  std::optional<PlyNumberKind> count;  // type of a list's count
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHead {
  bool has_format = false;
  bool text = false;
  double remarked_unit = 0;  // m
  bool swapped = false;      // byte order differs from this machine's
  std::vector<PlyElement> elements;
  std::string_view body;
};

/// Reads a head; returns what is wrong with it, or nothing.
std::string ReadPlyHead(std::string_view bytes, PlyHead& head);

}  // namespace tandem
