# cmake -DSOURCE=... -DOUT=FILE.cc -P build_stamp.cmake: kBuildStamp of service/scene/cache/cache_store.h, from the sources' contents.
set(all "")
foreach(folder base haptics scene)
  file(GLOB_RECURSE files RELATIVE ${SOURCE} ${SOURCE}/service/${folder}/*.h ${SOURCE}/service/${folder}/*.cc)
  list(SORT files)
  foreach(file ${files})
    file(SHA256 ${SOURCE}/${file} hash)
    string(APPEND all "${file} ${hash}\n")
  endforeach()
endforeach()
string(SHA256 stamp "${all}")
file(WRITE ${OUT}
     "#include \"service/scene/cache/cache_store.h\"\n\nnamespace omni::scene {\n\nconst char* const kBuildStamp = \"${stamp}\";\n\n}  // namespace omni::scene\n")
