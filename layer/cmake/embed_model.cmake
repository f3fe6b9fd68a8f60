# cmake -DOUTPUT=file.cc -DFILE=pen.glb -P embed_model.cmake: the file's bytes, and a UUID of them: the first 128 bits of
# their SHA-256 with the version and variant of RFC 9562, version 8.
file(READ ${FILE} bytes HEX)
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1,\n" bytes "${bytes}")
file(SHA256 ${FILE} hash)
string(SUBSTRING ${hash} 0 12 front)
string(SUBSTRING ${hash} 13 3 middle)
string(SUBSTRING ${hash} 17 15 back)
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1, " uuid "${front}8${middle}a${back}")
file(WRITE ${OUTPUT} "#include \"layer/src/models/pen_model.h\"\n
namespace omni::layer {
namespace {\n
constexpr std::uint8_t kPenModelBytes[] = {\n${bytes}};\n
}  // namespace\n
const PenModelFile& EmbeddedPenModel() {
  static const PenModelFile file{kPenModelBytes, {{${uuid}}}};
  return file;
}\n
}  // namespace omni::layer\n")
