#include "tests/fuzz/loaders.h"

#include <unistd.h>

#include <Eigen/Core>
#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>

#include "scenarios/cdr.h"
#include "scenarios/error.h"
#include "scenarios/mesh.h"
#include "scenarios/mjcf.h"
#include "scenarios/recording.h"
#include "scenarios/ros_message.h"
#include "scenarios/scenario.h"
#include "tests/fuzz/record_loaders.h"
#include "tests/fuzz/seeds.h"
#include "draft/draft.h"

namespace lacuna::test {
namespace fs = std::filesystem;

namespace {

const std::vector<std::string> kYamlTokens{":",
                                           ": ",
                                           "\n",
                                           "- ",
                                           "[",
                                           "]",
                                           "{",
                                           "}",
                                           "&a ",
                                           "*a",
                                           "!!str ",
                                           "? ",
                                           "|",
                                           ">",
                                           "#",
                                           "\"",
                                           "'",
                                           "---\n",
                                           "...\n",
                                           "%YAML 1.2\n",
                                           "~",
                                           "null",
                                           ".inf",
                                           ".nan",
                                           "1e999",
                                           "-1",
                                           "0",
                                           "joint_2",
                                           "../../x",
                                           "/dev/zero",
                                           "\t",
                                           " ",
                                           "\\x00",
                                           std::string(1, '\0'),
                                           "\xEF\xBB\xBF",
                                           "\xff",
                                           "value",
                                           "<<: "};
const std::vector<std::string> kNumbers{std::string(4, '\0'),
                                        std::string(8, '\xff'),
                                        std::string("\x01\0\0\0", 4),
                                        std::string("\xff\xff\xff\x7f", 4),
                                        std::string("\x03\0\0\0\0\0\0\0\0", 9),
                                        std::string("\x05\xff\xff\0\0\0\0\0\0", 9),
                                        "zstd",
                                        "lz4",
                                        std::string("\x28\xb5\x2f\xfd", 4),
                                        std::string("\x04\x22\x4d\x18", 4)};

void claim(bool holds, const char* what) {
  if (!holds) throw std::logic_error(std::string("accepted though untrue: ") + what);
}

std::shared_ptr<const Recording> load_columns(const fs::path& file, const RecordingLimits& limits = {}) {
  const auto data = load_recording(file, file.filename().string(), limits);
  for (const auto& column : data->columns) claim(column.size() == data->rows(), "columns of one length");
  return data;
}

/// A reader of one file that is called `name`.
template <const char* name>
void load_file(const fs::path& folder, const std::string& bytes) {
  write(folder / name, bytes);
  load_columns(folder / name);
}
constexpr char kDb3[] = "run.db3", kMcap[] = "run.mcap";

void prepare_scenario(const fs::path& folder) {
  fs::copy_file(kRoot / "scenarios/hydrolek/seed_table1.urdf", folder / "robot.urdf");
  fs::copy_file(kRoot / "scenarios/pendulum/pendulum.urdf", folder / "pendulum.urdf");
  write(folder / "run.csv", "t,u_1,u_2,q_1,q_2\n0,1,2,3,4\n0.01,1,2,3,4\n0.02,1,2,3,4\n0.03,1,2,3,4\n");
  fs::copy_file(folder / "run.csv", folder / "other.csv");
  write(folder / "more.csv", "s,p\n0.5,1\n0.51,2\n0.55,3\n");
}

void load_scenario_text(const fs::path& folder, const std::string& bytes) {
  write(folder / "scenario.yaml", bytes);
  load_scenario(folder / "scenario.yaml");
}

/// What is accepted can be written, and what is written can be read.
void load_urdf(const fs::path&, const std::string& bytes) {
  Robot::from_urdf_text(to_urdf(*Robot::from_urdf_text(bytes, "r.urdf")), "again.urdf");
}

void load_mjcf(const fs::path&, const std::string& bytes) {
  Robot::from_urdf_text(to_urdf(*read_mjcf_text(bytes, "m.xml").robot), "again.urdf");
}

void load_csv(const fs::path& folder, const std::string& bytes) {
  RecordingLimits limits;
  limits.line_bytes = 512;
  limits.columns = 16;
  write(folder / "run.csv", bytes);
  const auto data = load_columns(folder / "run.csv", limits);
  write_csv(folder / "again.csv", *data);
}

/// By its header a file of MATLAB 7.3, which takes a process of its own.
bool is_hdf5(const std::string& bytes) { return bytes.size() >= 128 && bytes.find_first_of('\2', 124) < 126; }

void load_mat(const fs::path& folder, const std::string& bytes) {
  if (is_hdf5(bytes)) return;
  write(folder / "run.mat", bytes);
  load_columns(folder / "run.mat");
}

void load_mat73(const fs::path& folder, const std::string& bytes) {
  if (!is_hdf5(bytes)) return;
  write(folder / "run.mat", bytes);
  load_columns(folder / "run.mat");
}

void prepare_bag(const fs::path& folder) {
  fs::create_directories(folder / "run");
  write(folder / "run/run_0.db3", seeds_of_db3().front());
}

void load_bag_metadata(const fs::path& folder, const std::string& bytes) {
  write(folder / "run/metadata.yaml", bytes);
  load_columns(folder / "run");
}

/// The first byte says of which type the message is.
void load_message(const fs::path&, const std::string& bytes) {
  if (bytes.empty()) return;
  const std::vector<std::string>& types = message_types();
  RosMessage message;
  try {
    decode_ros_message(*find_ros_type(types[static_cast<unsigned char>(bytes[0]) % types.size()]), bytes.substr(1),
                       message);
  } catch (const MessageFault& fault) {
    throw InputError("message", fault.found, fault.expected);
  }
}

/// The first byte says of which format the mesh is.
void load_mesh(const fs::path&, const std::string& bytes) {
  if (bytes.empty() || !meshes_available()) return;
  const std::string format = bytes[0] == 'o' ? "obj" : bytes[0] == 'd' ? "dae" : "stl";
  const Mesh mesh = read_mesh(bytes.substr(1), format, "m." + format);
  claim(!mesh.triangles.empty(), "a triangle");
  for (const Eigen::Vector3f& vertex : mesh.vertices) claim(vertex.allFinite(), "finite vertices");
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t corner : triangle) claim(corner < mesh.vertices.size(), "corners that are there");
}

void prepare_draft(const fs::path& folder) {
  fs::copy_file(kRoot / "scenarios/double_pendulum/double_pendulum.urdf", folder / "robot.urdf");
}

/// Whatever a recording is called and holds, its draft is a scenario.
void load_draft(const fs::path& folder, const std::string& bytes) {
  static const auto robot = Robot::from_urdf(folder / "robot.urdf");
  write(folder / "run.csv", bytes);
  const Draft draft = draft_scenario({"fuzz", "robot.urdf", robot, {{"run.csv", load_columns(folder / "run.csv")}}});
  write(folder / "scenario.yaml", draft.yaml);
  try {
    load_scenario(folder / "scenario.yaml", {.load_recordings = false});
  } catch (const InputError& error) {
    throw std::logic_error("drafted, but refused: " + std::string(error.what()));
  }
}

std::vector<Loader> all_loaders() {
  std::vector<Loader> out{
      {"scenario", kYamlTokens, seeds_of_scenario, load_scenario_text, prepare_scenario},
      {"urdf",
       {"<",
        ">",
        "/>",
        "</",
        "<!--",
        "-->",
        "<?",
        "?>",
        "<![CDATA[",
        "]]>",
        "&lt;",
        "&#0;",
        "'",
        "\"",
        "=",
        "<link name='x'/>",
        "<joint name='x' type='fixed'>",
        "type='floating'",
        "<mimic joint='joint_1'/>",
        "<mesh filename='a'/>",
        "<sphere/>",
        "<box/>",
        "<limit/>",
        "<mass value='-1'/>",
        "nan",
        "inf",
        "1e999",
        "0",
        "-",
        std::string(1, '\0'),
        "\xEF\xBB\xBF",
        "\xef",
        "\xff",
        "<a>",
        " name='y'",
        "</robot>",
        "<robot name='z'>",
        "<inertial>",
        "<origin rpy='1 2 3'/>",
        " version='9'"},
       seeds_of_urdf,
       load_urdf},
      {"mjcf",
       {"<",
        ">",
        "/>",
        "</body>",
        "<body>",
        "<joint/>",
        "<geom size='.1'/>",
        "<inertial mass='1'/>",
        "<include file='/dev/zero'/>",
        "<default class='x'>",
        "class='x'",
        "childclass='x'",
        "euler='1 2 3'",
        "quat='0 0 0 0'",
        "type='mesh'",
        "type='capsule'",
        "fromto='0 0 0 0 0 0'",
        "nan",
        "1e999",
        "-1",
        "0",
        "<equality>",
        "<tendon>",
        "'",
        "\"",
        std::string(1, '\0'),
        "\xff",
        "1e-320",
        "1e308"},
       seeds_of_mjcf,
       load_mjcf},
      {"csv",
       {",",
        ",,",
        "\n",
        "\r\n",
        "\r",
        "\"",
        "\"\"",
        "nan",
        "-nan",
        "inf",
        "1e999",
        "1e-999",
        "-",
        "+-",
        "0x1",
        "1e",
        " ",
        "\t",
        ";",
        "t",
        ".",
        "..",
        "e5",
        std::string(1, '\0'),
        "\xEF\xBB\xBF",
        "\xff",
        std::string(30, '9')},
       seeds_of_csv,
       load_csv},
      {"mat",
       {std::string(4, '\0'), std::string(4, '\xff'), std::string("\x0e\0\0\0", 4), std::string("\x0f\0\0\0", 4),
        std::string("\x01\0\0\0", 4), std::string("\0\0\0\x7f", 4)},
       seeds_of_mat,
       load_mat},
      {"mat73",
       {std::string(8, '\0'), std::string(8, '\xff'), "TREE", "SNOD", "HEAP", std::string("\x01\0\0\0", 4),
        "MATLAB_class", "t", "OHDR"},
       seeds_of_mat73,
       load_mat73},
      {"db3", kNumbers, seeds_of_db3, load_file<kDb3>},
      {"mcap", kNumbers, seeds_of_mcap, load_file<kMcap>},
      {"bag_metadata",
       {": ",        "\n", "- ", "[",    "]",       "{",    "}", "~",  "../", "/dev/zero", "metadata.yaml",
        "run_0.db3", ".",  "..", "FILE", "MESSAGE", "zstd", " ", "\"", "\xff"},
       seeds_of_bag_metadata,
       load_bag_metadata,
       prepare_bag},
      {"message", kNumbers, seeds_of_message, load_message},
      {"mesh",
       {"facet",
        "endfacet",
        "outer loop",
        "vertex",
        "endsolid",
        "solid",
        "\n",
        "\\\n",
        "f 1 2 3",
        "f -1 -2 -3",
        "f 99999999 1 2",
        "f 1//",
        "f 1/1/1 2/2/2 3/3/3",
        "usemtl x",
        "mtllib /dev/zero",
        "v 1",
        "vn 0 0 1",
        "l 1 2",
        "p 1",
        "curv",
        "nan",
        "inf",
        "1e999",
        "-",
        "<",
        ">",
        "/>",
        "</p>",
        "<p>",
        "count='99999999'",
        "stride='0'",
        "#v",
        "#p",
        "url='#n'",
        "<instance_node url='#n'/>",
        "<node>",
        "</node>",
        "<polylist>",
        "<vcount>",
        "offset='9'",
        "1.5",
        " .5 ",
        "1e3",
        " x ",
        "<!-- -->",
        std::string(4, '\xff'),
        std::string(4, '\0'),
        "\xff"},
       seeds_of_mesh,
       load_mesh},
      {"draft",
       {",",  "\n",    "q_1", "u_2",   "tau_1",  "i_2",    "qd_1", "t", "deg",  "joint_2", "#",
        ": ", "\"{\"", "0",   "1e308", "-1e308", "1e-320", "nan",  "",  "9999", "_ms",     "\xff"},
       seeds_of_draft,
       load_draft,
       prepare_draft},
  };
  const std::vector<Loader> records = record_loaders();
  out.insert(out.end(), records.begin(), records.end());
  return out;
}

/// A folder for each loader, gone with the process.
class Folders {
 public:
  ~Folders() {
    std::error_code ignored;
    fs::remove_all(root_, ignored);
  }
  const fs::path& of(const Loader& loader) {
    const auto [at, fresh] = folders_.emplace(loader.name, root_ / loader.name);
    if (!fresh) return at->second;
    fs::create_directories(at->second);
    if (loader.prepare != nullptr) loader.prepare(at->second);
    return at->second;
  }

 private:
  fs::path root_ = fs::temp_directory_path() / ("lacuna_loaders_" + std::to_string(::getpid()));
  std::map<std::string, fs::path> folders_;
};

}  // namespace

const std::vector<Loader>& loaders() {
  static const std::vector<Loader> all = all_loaders();
  return all;
}

const Loader& loader(std::string_view name) {
  const auto at = std::find_if(loaders().begin(), loaders().end(), [&](const Loader& one) { return one.name == name; });
  if (at == loaders().end()) throw std::logic_error("no loader " + std::string(name));
  return *at;
}

void loads(const Loader& loader, const std::string& bytes) {
  static Folders folders;
  loader.load(folders.of(loader), bytes);
}

std::string fault_of(const Loader& loader, const std::string& bytes) {
  return fault_of([&] { loads(loader, bytes); });
}

std::string fault_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const InputError& error) {
    for (const char c : std::string(error.what()))
      if (static_cast<unsigned char>(c) < 0x20) return std::string("a control character in: ") + error.what();
  } catch (const std::exception& error) {
    return std::string("another exception: ") + error.what();
  }
  return "";
}

std::string read(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void write(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary | std::ios::trunc) << text;
}

}  // namespace lacuna::test
