#include "data-tools/meshes/glb_file.h"

#include <cctype>
#include <charconv>
#include <glm/common.hpp>

namespace trephine::data_tools {

namespace {

template <class T>
void put(std::string& out, const T& value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string json_of(std::span<const float> numbers) {
  std::string text = "[";
  for (const float number : numbers) {
    char digits[40];
    if (text.size() > 1) text += ',';
    text.append(digits, std::to_chars(digits, digits + sizeof digits, number).ptr);
  }
  return text + "]";
}
std::string json_of(const glm::vec3& v) { return json_of(std::array{v.x, v.y, v.z}); }

/// Returns the name without characters that a JSON text would have to escape.
std::string plain(const std::string& name) {
  std::string text;
  for (const char c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == ' ' || c == '.' || c == '-') text += c;
  return text;
}

/// Lists of a glTF scene in JSON, and its numbers.
struct Gltf {
  std::string nodes, meshes, materials, views, accessors, roots, numbers;
  int count = 0;  ///< of nodes; each has a mesh, a material, two views and two accessors

  void add(const ScenePart& part) {
    const std::string comma = count > 0 ? "," : "", n = std::to_string(count);
    const std::size_t at = numbers.size();
    glm::vec3 low(1e30F), high(-1e30F);
    for (const glm::vec3& p : part.vertices) {
      const glm::vec3 q = 1e-3F * glm::vec3(p.x, p.z, -p.y);
      low = glm::min(low, q);
      high = glm::max(high, q);
      put(numbers, q);
    }
    const std::size_t middle = numbers.size();
    for (const std::uint32_t index : part.indices) put(numbers, index);

    roots += comma + n;
    nodes += comma + "{\"mesh\":" + n + ",\"name\":\"" + plain(part.name) + "\"}";
    meshes += comma + "{\"primitives\":[{\"attributes\":{\"POSITION\":" + std::to_string(2 * count) +
              "},\"indices\":" + std::to_string(2 * count + 1) + ",\"material\":" + n +
              (part.are_lines ? ",\"mode\":1" : "") + "}]}";
    const auto& c = part.colour;
    materials += comma + "{\"pbrMetallicRoughness\":{\"baseColorFactor\":" +
                 json_of(std::array{c[0], c[1], c[2], 1.0F}) +
                 ",\"metallicFactor\":0,\"roughnessFactor\":0.7},\"doubleSided\":true}";
    const auto view = [&](std::size_t from, std::size_t to, const char* target) {
      return "{\"buffer\":0,\"byteOffset\":" + std::to_string(from) +
             ",\"byteLength\":" + std::to_string(to - from) + ",\"target\":" + target + "}";
    };
    views += comma + view(at, middle, "34962") + "," + view(middle, numbers.size(), "34963");
    accessors += comma + "{\"bufferView\":" + std::to_string(2 * count) +
                 ",\"componentType\":5126,\"count\":" + std::to_string(part.vertices.size()) +
                 ",\"type\":\"VEC3\",\"min\":" + json_of(low) + ",\"max\":" + json_of(high) +
                 "},{\"bufferView\":" + std::to_string(2 * count + 1) +
                 ",\"componentType\":5125,\"count\":" + std::to_string(part.indices.size()) +
                 ",\"type\":\"SCALAR\"}";
    ++count;
  }
  std::string json() const {
    return "{\"asset\":{\"version\":\"2.0\",\"generator\":\"trephine\"},\"scene\":0,\"scenes\":[{\"nodes\":[" +
           roots + "]}],\"nodes\":[" + nodes + "],\"meshes\":[" + meshes + "],\"materials\":[" + materials +
           "],\"buffers\":[{\"byteLength\":" + std::to_string(numbers.size()) + "}],\"bufferViews\":[" +
           views + "],\"accessors\":[" + accessors + "]}";
  }
};

}  // namespace

std::string glb_of(std::span<const ScenePart> parts) {
  Gltf gltf;
  for (const ScenePart& part : parts)
    if (!part.indices.empty()) gltf.add(part);
  // A header, the JSON chunk, and the binary chunk.
  std::string json = gltf.count > 0
                         ? gltf.json()
                         : R"({"asset":{"version":"2.0","generator":"trephine"},"scene":0,"scenes":[{}]})";
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::string out = "glTF";
  put(out, std::uint32_t{2});
  put(out, static_cast<std::uint32_t>(12 + 8 + json.size() + 8 + gltf.numbers.size()));
  put(out, static_cast<std::uint32_t>(json.size()));
  out += "JSON" + json;
  put(out, static_cast<std::uint32_t>(gltf.numbers.size()));
  out.append("BIN\0", 4);
  return out + gltf.numbers;
}

}  // namespace trephine::data_tools
