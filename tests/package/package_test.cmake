# Installs to a folder of its own, moves it, builds examples/own-formulation against it and runs it; compiles every
# installed header alone; configures a project that has lanc as a subdirectory.
cmake_minimum_required(VERSION 3.25)

set(work "${BUILD}/tests/package/work")
file(REMOVE_RECURSE "${work}")
set(flags)
if(SANITIZE)
  set(flags "-fsanitize=${SANITIZE}")
endif()

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(code)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "${command}\nended with ${code}:\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

# configure(FOLDER BUILD [options])
function(configure folder build)
  run(${CMAKE_COMMAND} -S "${folder}" -B "${build}" -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${COMPILER}
      -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER} "-DCMAKE_CXX_FLAGS=${flags}" ${ARGN})
endfunction()

# As a package that was moved after it was installed.
run(${CMAKE_COMMAND} --install "${BUILD}" --prefix "${work}/first")
file(RENAME "${work}/first" "${work}/prefix")

configure("${SOURCE}/examples/own-formulation" "${work}/example" "-DCMAKE_PREFIX_PATH=${work}/prefix")
run(${CMAKE_COMMAND} --build "${work}/example")
run("${work}/example/own-formulation" chain:5:joint=spherical)
message("${output}")
foreach(expected recursive dense eigen-lu)
  if(NOT output MATCHES "${expected} +solved")
    message(FATAL_ERROR "the example did not solve by '${expected}'")
  endif()
endforeach()

if(NOT SANITIZE)  # only compiled, so the sanitizers have nothing to find
  configure("${SOURCE}/tests/package/headers" "${work}/headers" "-DCMAKE_PREFIX_PATH=${work}/prefix"
            "-DINSTALLED=${work}/prefix")
  run(${CMAKE_COMMAND} --build "${work}/headers")
endif()

# As a subdirectory: brings its library, not its programs and tests.
configure("${SOURCE}/tests/package/subdirectory" "${work}/subdirectory" "-DLANC=${SOURCE}")
