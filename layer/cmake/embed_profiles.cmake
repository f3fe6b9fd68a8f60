# cmake -DOUTPUT=file.cc -DFILES="a.json;b.json" -P embed_profiles.cmake: the profile files as string literals.
set(rows "")
foreach(file ${FILES})
  file(READ ${file} text)
  get_filename_component(name ${file} NAME)
  string(APPEND rows "      {\"${name}\", R\"omni_json(${text})omni_json\"},\n")
endforeach()
file(WRITE ${OUTPUT} "#include \"layer/src/actions/profile.h\"\n
namespace omni::layer {\n
const std::vector<EmbeddedFile>& EmbeddedProfiles() {
  static const std::vector<EmbeddedFile> files{\n${rows}  };
  return files;
}\n
}  // namespace omni::layer\n")
