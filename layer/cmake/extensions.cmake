# layer/extensions.json is the one list of the extensions that this layer answers. From it come, at configuration,
#   our_extensions.cc       the table behind OurExtensions(), which xrEnumerateInstanceExtensionProperties answers with
#   OMNI_LAYER_EXTENSIONS   "instance_extensions" of every manifest
# An extension: name; version; may_be_below: requested from the runtime first; otherwise only we know it and it is
# never passed down; needs, if any: another extension of the list without which xrCreateInstance fails;
# entrypoints: its functions, as in OwnFunctions() (a test compares them).
set(list_file ${CMAKE_CURRENT_SOURCE_DIR}/extensions.json)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${list_file})
file(READ ${list_file} list_text)
string(JSON list_length LENGTH "${list_text}" extensions)

set(OMNI_LAYER_EXTENSIONS "")
set(table_rows "")
math(EXPR list_last "${list_length} - 1")
foreach(i RANGE ${list_last})
  string(JSON name GET "${list_text}" extensions ${i} name)
  string(JSON version GET "${list_text}" extensions ${i} version)
  string(JSON may_be_below GET "${list_text}" extensions ${i} may_be_below)
  string(JSON functions_length LENGTH "${list_text}" extensions ${i} entrypoints)
  set(functions "")
  if(functions_length GREATER 0)
    math(EXPR functions_last "${functions_length} - 1")
    foreach(k RANGE ${functions_last})
      string(JSON function GET "${list_text}" extensions ${i} entrypoints ${k})
      list(APPEND functions "\"${function}\"")
    endforeach()
  endif()
  list(JOIN functions ", " functions)
  if(may_be_below)
    set(below true)
  else()
    set(below false)
  endif()
  string(JSON needs ERROR_VARIABLE none GET "${list_text}" extensions ${i} needs)
  if(needs)
    set(needs "\"${needs}\"")
  else()
    set(needs nullptr)
  endif()
  if(i GREATER 0)
    string(APPEND OMNI_LAYER_EXTENSIONS ",\n      ")
  endif()
  string(APPEND OMNI_LAYER_EXTENSIONS
         "{\"name\": \"${name}\", \"extension_version\": \"${version}\", \"entrypoints\": [${functions}]}")
  string(APPEND table_rows "      {\"${name}\", ${version}, ${below}, ${needs}},\n")
endforeach()

set(extensions_cc ${CMAKE_CURRENT_BINARY_DIR}/our_extensions.cc)
file(CONFIGURE OUTPUT ${extensions_cc} @ONLY CONTENT [[#include "layer/src/entry/own_extensions.h"

namespace omni::layer {

// Made from layer/extensions.json.
std::span<const OurExtension> OurExtensions() {
  static constexpr OurExtension kAll[] = {
@table_rows@  };
  return kAll;
}

}  // namespace omni::layer
]])
