# Writes OUT, a source that holds FILES (names with | between) byte by byte, by the function FUNCTION of NAMESPACE that HEADER declares:
# run by the build whenever one of them changes.
set(text "#include \"${HEADER}\"\n\nnamespace ${NAMESPACE} {\n\nnamespace {\n\n")
set(table "")
string(REPLACE "|" ";" files "${FILES}")
set(number 0)
foreach(file ${files})
  get_filename_component(name ${file} NAME)
  file(READ ${file} bytes HEX)
  string(REGEX REPLACE "(................................................................)" "\\1\n" bytes "${bytes}")
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
  string(APPEND text "constexpr unsigned char kBytes${number}[] = {\n${bytes}};\n\n")
  string(APPEND table "  if (name == \"${name}\") return {reinterpret_cast<const char*>(kBytes${number}), sizeof kBytes${number}};\n")
  math(EXPR number "${number} + 1")
endforeach()
string(APPEND text "}  // namespace\n\nstd::string_view ${FUNCTION}(std::string_view name) {\n${table}  return {};\n}\n\n"
  "}  // namespace ${NAMESPACE}\n")
file(WRITE ${OUT} "${text}")
