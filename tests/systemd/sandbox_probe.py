"""Run by inside.py in the mirror's own sandbox, in the mirror's place: what its processes need must work, and what an
intruder would want must not. Prints a line for each; exits with 1 if one is not as it should be."""
import ctypes
import errno
import mmap
import os
import pathlib
import resource
import signal
import socket
import subprocess
import sys

NETLINK_KOBJECT_UEVENT = 15  # From linux/netlink.h; Python has no name for it.
PR_SET_PDEATHSIG = 1
CLONE_NEWUSER = 0x10000000
PTRACE_ATTACH = 16
FAULTS = []


def allowed(what, action):
    try:
        action()
    except OSError as fault:
        FAULTS.append(what)
        print(f"failed: {what}: {fault}")
    else:
        print(f"ok: allowed: {what}")


def refused(what, action, *numbers):
    try:
        action()
    except OSError as fault:
        good = fault.errno in numbers
        print(f"{'ok' if good else 'failed'}: refused: {what}: {fault.strerror}")
    else:
        good = False
        print(f"failed: {what} works")
    if not good:
        FAULTS.append(what)


def call(name, *arguments):
    """A function of the C library that Python does not wrap."""
    library = ctypes.CDLL(None, use_errno=True)
    if getattr(library, name)(*arguments) == -1:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))


def child_is_killed_by_pidfd():
    left, right = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    # The sensor process: a child with a socket to it, which can be ended whatever it hangs in.
    with subprocess.Popen(["/bin/cat"], stdin=right, stdout=subprocess.DEVNULL) as child:
        descriptor = os.pidfd_open(child.pid)
        signal.pidfd_send_signal(descriptor, signal.SIGSTOP)
        os.kill(child.pid, signal.SIGKILL)
        os.waitid(os.P_PIDFD, descriptor, os.WEXITED)
        os.close(descriptor)
    left.close()
    right.close()


def shared_ring():
    descriptor = os.memfd_create("ring", os.MFD_ALLOW_SEALING)
    os.ftruncate(descriptor, 1 << 20)
    with mmap.mmap(descriptor, 1 << 20) as ring:
        ring[0] = 1
    left, right = socket.socketpair()
    event = os.eventfd(0)
    socket.send_fds(left, [b"x"], [descriptor, event])
    for received in socket.recv_fds(right, 1, 2)[1]:
        os.close(received)
    os.close(descriptor)
    os.close(event)


def hot_plug():
    with socket.socket(socket.AF_NETLINK, socket.SOCK_RAW, NETLINK_KOBJECT_UEVENT) as events:
        events.bind((0, 2))


def state_file():
    path = pathlib.Path("/var/lib/cheval/probe")
    path.write_text("state")
    with path.open() as file:
        os.fsync(file.fileno())
    path.rename("/var/lib/cheval/probe.done")
    pathlib.Path("/var/lib/cheval/probe.done").unlink()
    pathlib.Path("/run/cheval/probe").write_text("metrics")


def killed_with_its_parent():
    call("prctl", PR_SET_PDEATHSIG, signal.SIGKILL)


def write_and_execute():
    mmap.mmap(-1, 4096, prot=mmap.PROT_READ | mmap.PROT_WRITE | mmap.PROT_EXEC).close()


allowed("a child that is ended through its pidfd", child_is_killed_by_pidfd)
allowed("memfd, eventfd and passing them on", shared_ring)
allowed("netlink, for sensors that come and go", hot_plug)
allowed("state and run-time files", state_file)
allowed("to die with one's parent", killed_with_its_parent)
allowed("memory to compile shaders into", write_and_execute)
allowed("devices of its groups", lambda: os.close(os.open("/run/device-of-plugdev", os.O_RDWR | os.O_NONBLOCK)))
allowed("reading the settings", lambda: os.listdir("/etc/cheval"))
allowed("looking for USB devices", lambda: os.listdir("/sys/bus"))
allowed("counting processors", lambda: os.sched_getaffinity(0))

refused("the internet", lambda: socket.socket(socket.AF_INET, socket.SOCK_STREAM), errno.EAFNOSUPPORT)
refused("raw packets", lambda: socket.socket(socket.AF_PACKET, socket.SOCK_RAW), errno.EAFNOSUPPORT)
refused("changing the program", lambda: open("/usr/local/bin/chevald", "ab"), errno.EROFS, errno.EACCES)
refused("changing the settings", lambda: open("/etc/cheval/more.toml", "w"), errno.EROFS, errno.EACCES)
refused("devices of others", lambda: os.open("/run/device-of-root", os.O_RDWR | os.O_NONBLOCK), errno.EACCES)
refused("people's folders", lambda: os.listdir("/home"), errno.EACCES, errno.ENOENT)
refused("a new user namespace", lambda: call("unshare", CLONE_NEWUSER), errno.EPERM)
refused("mounting", lambda: call("mount", b"none", b"/mnt", b"tmpfs", 0, None), errno.EPERM)
refused("system calls of administrators", lambda: call("swapoff", b"/nowhere"), errno.EPERM)
refused("watching other processes", lambda: call("ptrace", PTRACE_ATTACH, os.getppid(), None, None), errno.EPERM)
refused("a set-user-ID file", lambda: os.chmod("/run/cheval/probe", 0o4755), errno.EPERM)
refused("processes of others", lambda: os.listdir("/proc/1/"), errno.ENOENT)
refused("the kernel's settings", lambda: os.listdir("/proc/sys"), errno.ENOENT)
if resource.getrlimit(resource.RLIMIT_CORE)[1] != 0:
    FAULTS.append("core files")
    print("failed: a core file, with the shoppers' pictures in it, may be written")
sys.exit(1 if FAULTS else 0)
