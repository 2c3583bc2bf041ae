# One library, one folder a room. A room may include only rooms below it (checked by the `architecture` test):
# reports, render, study, diagnosis, compare -> ga -> physics -> backends -> scenarios; diff and trial between reports and diagnosis.
file(GLOB_RECURSE LACUNA_SOURCES CONFIGURE_DEPENDS
  scenarios/*.cc backends/*.cc physics/*.cc ga/*.cc draft/*.cc study/*.cc diagnosis/*.cc diff/*.cc compare/*.cc trial/*.cc reports/*.cc render/*.cc)

list(FILTER LACUNA_SOURCES EXCLUDE REGEX "scenarios/generate/")

list(JOIN LACUNA_PACKAGE_ENGINES "|" engines)
list(FILTER LACUNA_SOURCES EXCLUDE REGEX "backends/(${engines})/")
list(APPEND LACUNA_SOURCES ${LACUNA_ENGINE_SOURCES} ${LACUNA_MISSING_ENGINES})
if(LACUNA_WITH_RENDER AND LACUNA_WITH_MUJOCO)
  list(FILTER LACUNA_SOURCES EXCLUDE REGEX "render/stub\\.cc$")
else()
  list(FILTER LACUNA_SOURCES EXCLUDE REGEX "render/osmesa.*\\.cc$")
endif()
if(LACUNA_WITH_ASSIMP)
  list(FILTER LACUNA_SOURCES EXCLUDE REGEX "scenarios/mesh_stub\\.cc$")
  set_source_files_properties(scenarios/assimp_import.cc PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
else()
  list(FILTER LACUNA_SOURCES EXCLUDE REGEX "scenarios/assimp_import\\.cc$")
endif()
# MPI stands in a library of its own, loaded when a launcher started us as a rank.
list(FILTER LACUNA_SOURCES EXCLUDE REGEX "physics/mpi/mpi_transport\\.cc$")
if(LACUNA_WITH_MPI)
  list(FILTER LACUNA_SOURCES EXCLUDE REGEX "physics/mpi/stub\\.cc$")
else()
  list(FILTER LACUNA_SOURCES EXCLUDE REGEX "physics/mpi/load\\.cc$")
endif()

# What a report's page runs in the browser, put into the library (reports/page_assets.h).
include(cmake/page.cmake)

# Rooms that run once a job and are read by people: half the time to compile, none that anyone would notice to run.
set(LACUNA_PAGES ${LACUNA_SOURCES})
list(FILTER LACUNA_PAGES INCLUDE REGEX "/(draft|study|trial|reports)/[^/]*$")
list(REMOVE_ITEM LACUNA_SOURCES ${LACUNA_PAGES})
add_library(lacuna_pages OBJECT ${LACUNA_PAGES} ${LACUNA_PAGE_SOURCE})
target_include_directories(lacuna_pages PRIVATE $<TARGET_PROPERTY:lacuna,INCLUDE_DIRECTORIES>)
target_compile_definitions(lacuna_pages PRIVATE $<TARGET_PROPERTY:lacuna,COMPILE_DEFINITIONS>)
target_link_libraries(lacuna_pages PRIVATE lacuna_flags lacuna_unhurried)

add_library(lacuna SHARED ${LACUNA_SOURCES})
add_library(lacuna::lacuna ALIAS lacuna)
set_target_properties(lacuna PROPERTIES VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR})
target_include_directories(lacuna PUBLIC
  $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/lacuna>)
# One alignment for Eigen's types in every translation unit and in users' code, whatever instruction set each is built for.
target_compile_definitions(lacuna PUBLIC EIGEN_MAX_ALIGN_BYTES=16)
if(LACUNA_SANITIZE)
  # Eigen would allocate differently under a sanitizer than inside Debian's pagmo, which frees what our code allocated.
  target_compile_definitions(lacuna PUBLIC $<BUILD_INTERFACE:EIGEN_MALLOC_ALREADY_ALIGNED=1>)
endif()
target_link_libraries(lacuna
  PUBLIC Eigen3::Eigen
  PRIVATE $<BUILD_INTERFACE:lacuna_flags> Threads::Threads yaml-cpp nlohmann_json::nlohmann_json fmt::fmt
          spdlog::spdlog Ceres::ceres Pagmo::pagmo TBB::tbb Boost::headers PNG::PNG OpenSSL::Crypto PkgConfig::URDFDOM
          PkgConfig::MATIO PkgConfig::TINYXML2 PkgConfig::SQLITE3 PkgConfig::LZ4 PkgConfig::ZSTD)
target_include_directories(lacuna SYSTEM PRIVATE ${RANDOM123_INCLUDE} ${LACUNA_ENGINE_INCLUDES})
target_link_libraries(lacuna PRIVATE ${LACUNA_ENGINE_LIBRARIES})
if(LACUNA_WITH_RENDER AND LACUNA_WITH_MUJOCO)
  # Loaded when it is needed, by the name that its programs look for.
  get_filename_component(osmesa ${OSMESA_LIBRARY} REALPATH)
  string(REGEX MATCH "[^/]*\\.so\\.[0-9]+" osmesa ${osmesa})
  set_source_files_properties(render/osmesa.cc PROPERTIES COMPILE_DEFINITIONS LACUNA_OSMESA="${osmesa}")
  target_link_libraries(lacuna PRIVATE ${CMAKE_DL_LIBS})
endif()
if(LACUNA_WITH_ASSIMP)
  target_include_directories(lacuna SYSTEM PRIVATE ${ASSIMP_INCLUDE_DIR})
  target_link_libraries(lacuna PRIVATE ${ASSIMP_LIBRARY})
endif()
if(LACUNA_WITH_MPI)
  target_link_libraries(lacuna PRIVATE ${CMAKE_DL_LIBS})
  add_library(lacuna_mpi MODULE physics/mpi/mpi_transport.cc)
  target_link_libraries(lacuna_mpi PRIVATE lacuna lacuna_flags MPI::MPI_CXX)
endif()

# The lanes and the fused scalar kernel: one source over every instruction set, chosen at run time. The baseline goes first, so that the linker
# keeps its copies of shared inline functions, which every CPU can run.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  set_source_files_properties(physics/predictor_avx2.cc backends/featherstone/forward_kernel_fma.cc PROPERTIES
    COMPILE_OPTIONS "-mavx2;-mfma;-ffp-contract=fast")
  set_source_files_properties(physics/predictor_avx512.cc PROPERTIES
    # GCC 12 warns of its own intrinsics' undefined lanes.
    COMPILE_OPTIONS "-Wno-uninitialized;-Wno-maybe-uninitialized;-mavx512f;-mavx512dq;-mavx512vl;-mavx512bw;-mavx512cd;-mavx2;-mfma;-ffp-contract=fast;-mprefer-vector-width=512")
endif()
# Kernels stay units of their own in a unity build (they rely on what each defines before its includes), as do the
# engines that need a package, whose headers do not bear each other.
set(LACUNA_KERNELS physics/predictor_engine.cc physics/predictor_sse2.cc physics/predictor_avx2.cc
  physics/predictor_avx512.cc backends/featherstone/featherstone_engine.cc backends/featherstone/forward_kernel_fma.cc)
set_source_files_properties(${LACUNA_KERNELS} ${LACUNA_ENGINE_SOURCES} PROPERTIES
  SKIP_UNITY_BUILD_INCLUSION ON)
if(LACUNA_SANITIZE AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # Their thousands of temporaries are poisoned and cleared at every brace otherwise, which takes some six times as long;
  # that they do not outlive their function is still watched.
  set_property(SOURCE ${LACUNA_KERNELS} APPEND PROPERTY COMPILE_OPTIONS -O2 -fno-sanitize-address-use-after-scope)
endif()
list(FILTER LACUNA_SOURCES EXCLUDE REGEX "physics/predictor_avx.*\\.cc$|featherstone/forward_kernel_fma\\.cc$")
set_property(TARGET lacuna PROPERTY SOURCES ${LACUNA_SOURCES}
             $<TARGET_OBJECTS:lacuna_pages>
             ${PROJECT_SOURCE_DIR}/backends/featherstone/forward_kernel_fma.cc
             ${PROJECT_SOURCE_DIR}/physics/predictor_avx2.cc
             ${PROJECT_SOURCE_DIR}/physics/predictor_avx512.cc)

# Where results come from, told to the one file that writes it down (reports/context.h).
find_package(Git QUIET)
set(LACUNA_COMMIT "")
if(Git_FOUND)
  execute_process(COMMAND ${GIT_EXECUTABLE} rev-parse --short HEAD WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
                  OUTPUT_VARIABLE LACUNA_COMMIT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
if(EXISTS ${PROJECT_SOURCE_DIR}/.git/logs/HEAD)  # every commit is a reason to configure anew
  set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/.git/logs/HEAD)
endif()
if(NOT LACUNA_COMMIT)
  set(LACUNA_COMMIT "unknown")
endif()
string(TOUPPER "${CMAKE_BUILD_TYPE}" LACUNA_BUILD_TYPE_UPPER)
get_target_property(LACUNA_FLAGS lacuna_flags INTERFACE_COMPILE_OPTIONS)
list(FILTER LACUNA_FLAGS EXCLUDE REGEX "^-W")
list(PREPEND LACUNA_FLAGS ${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${LACUNA_BUILD_TYPE_UPPER}})
list(JOIN LACUNA_FLAGS " " LACUNA_FLAGS)
set_source_files_properties(reports/context.cc PROPERTIES COMPILE_DEFINITIONS
  "LACUNA_VERSION=\"${PROJECT_VERSION}\";LACUNA_COMPILER=\"${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}\";LACUNA_FLAGS=\"${LACUNA_FLAGS}\";LACUNA_BUILD_TYPE=\"${CMAKE_BUILD_TYPE}\";LACUNA_COMMIT=\"${LACUNA_COMMIT}\"")
