// gantry bus capture FILE.pcapng: everything on a network interface, beside whoever owns it; or the bring-up of the
// virtual segment in this process.
#include <arpa/inet.h>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fmt/format.h>
#include <linux/if_packet.h>
#include <net/ethernet.h>
#include <net/if.h>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "app/cli/bus_access.hpp"
#include "app/cli/pcapng_writer.hpp"
#include "app/cli/terminal.hpp"
#include "app/cli/usage.hpp"
#include "devices/ethercat/master.hpp"
#include "devices/passing_port.hpp"
#include "sim/segment/segment_port.hpp"

namespace gantry::cli {
namespace {

struct CaptureOptions : BusOptions {
  std::string file;
  double seconds = 0;
  std::uint64_t frames = 0;
};

std::uint64_t since_1970_ns() {
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
          .count());
}

/// Passes frames on and writes them down.
class TapPort final : public devices::PassingPort {
 public:
  TapPort(devices::FramePort& port, const Clock& clock, PcapngWriter& file)
      : PassingPort(port), file_(file), clock_(clock), begin_ns_(since_1970_ns()), begin_(clock.now()) {}
  bool send(devices::PortIndex port, std::span<const std::byte> frame) noexcept override {
    file_.add(stamp(), frame);
    return port_.send(port, frame);
  }
  devices::Received receive(std::span<std::byte> buffer, Time deadline) noexcept override {
    const auto got = port_.receive(buffer, deadline);
    if (got.size > 0) file_.add(stamp(), buffer.first(got.size));
    return got;
  }

 private:
  [[nodiscard]] std::uint64_t stamp() const {
    return begin_ns_ + static_cast<std::uint64_t>((clock_.now() - begin_).count());
  }
  PcapngWriter& file_;
  const Clock& clock_;
  std::uint64_t begin_ns_;
  Time begin_;
};

Result<void> capture_bring_up(const config::Machine& machine, PcapngWriter& file) {
  VirtualClock clock;
  sim::Segment segment(machine, clock);
  sim::SegmentPort port(segment, clock);
  TapPort tap(port, clock, file);
  devices::EthercatMaster master(machine, tap, clock);
  auto up = master.bring_up();
  if (up) master.shut_down();
  return up;
}

tl::unexpected<Error> problem_of(const CaptureOptions& options, const char* what) {
  return fail(Fault::InterfaceUnusable, fmt::format("{}: {}", what, std::strerror(errno)),
              "interface " + options.interface);
}

/// Its number.
Result<unsigned> interface_of(const CaptureOptions& options) {
  const unsigned index = ::if_nametoindex(options.interface.c_str());
  if (index == 0) return problem_of(options, "there is no such interface");
  return index;
}

/// Both directions, without a part in the traffic; ends by Ctrl-C, --seconds or --frames.
Result<void> listen(const CaptureOptions& options, unsigned index, PcapngWriter& file) {
  const auto problem = [&](const char* what) { return problem_of(options, what); };
  const int fd = ::socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, htons(ETH_P_ALL));
  if (fd < 0) return problem("cannot open a raw socket (it needs CAP_NET_RAW)");
  const struct Closer {
    int fd;
    ~Closer() { ::close(fd); }
  } closer{fd};
  const int buffer_bytes = 8 << 20;  // so that a busy disk loses nothing
  ::setsockopt(fd, SOL_SOCKET, SO_RCVBUFFORCE, &buffer_bytes, sizeof buffer_bytes);
  sockaddr_ll address{};
  address.sll_family = AF_PACKET;
  address.sll_protocol = htons(ETH_P_ALL);
  address.sll_ifindex = static_cast<int>(index);
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return problem("cannot bind to it");
  packet_mreq promiscuous{};
  promiscuous.mr_ifindex = static_cast<int>(index);
  promiscuous.mr_type = PACKET_MR_PROMISC;
  ::setsockopt(fd, SOL_PACKET, PACKET_ADD_MEMBERSHIP, &promiscuous, sizeof promiscuous);
  std::array<std::byte, 65536> frame;
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(options.seconds);
  while (!interrupted() && (options.frames == 0 || file.frames() < options.frames) &&
         (options.seconds <= 0 || std::chrono::steady_clock::now() < end)) {
    pollfd p{.fd = fd, .events = POLLIN, .revents = 0};
    constexpr int kLook_ms = 50;
    if (::poll(&p, 1, kLook_ms) <= 0) continue;
    const ssize_t got = ::recv(fd, frame.data(), frame.size(), 0);
    if (got > 0) file.add(since_1970_ns(), std::span(frame).first(static_cast<std::size_t>(got)));
    if (got < 0 && errno == ENETDOWN) return problem("it went down");
  }
  return {};
}

}  // namespace

void add_bus_capture(CLI::App& bus, Context& context) {
  auto* verb = bus.add_subcommand("capture", "Writes frames into a file that Wireshark reads");
  auto options = std::make_shared<CaptureOptions>();
  verb->add_option("FILE", options->file, "The file, .pcapng")->required()->check(file_to_be);
  add_bus_interface(*verb, *options);
  verb->add_option("--seconds", options->seconds, "End after so long; default: until Ctrl-C")->check(above_zero);
  verb->add_option("--frames", options->frames, "End after so many frames")->check(above_zero);
  verb->footer(
      "With --interface everything in both directions, also beside a controller that runs there. Without: the bring-up "
      "of\n"
      "--machine on its virtual segment, up to SAFE_OP.\n"
      "Example:  gantry bus capture bus.pcapng --interface eth1 --seconds 10\n"
      "          tshark -r bus.pcapng -Y _ws.malformed");
  verb->callback([&context, options] {
    std::optional<config::Machine> machine;
    if (options->interface.empty() && !(machine = load_machine(context))) return;
    const auto interface = machine ? Result<unsigned>(0) : interface_of(*options);
    if (!interface) return void(context.exit_code = show(interface.error(), context.json));
    auto file = PcapngWriter::create(options->file);
    if (!file) return void(context.exit_code = show(file.error(), context.json));
    auto done = machine ? capture_bring_up(*machine, **file) : listen(*options, *interface, **file);
    if (auto closed = (*file)->close(); done) done = closed;
    if (!done) return void(context.exit_code = show(done.error(), context.json));
    if (context.json)
      show_document("done", {{"file", options->file}, {"frames", (*file)->frames()}});
    else
      print_text("{} frames in {}\n", (*file)->frames(), options->file);
  });
}

}  // namespace gantry::cli
