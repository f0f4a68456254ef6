#!/bin/sh
# Takes a fresh Debian or Raspberry Pi OS board to a running agent, or a laptop to a running map server. Running it again updates.
set -eu
umask 022 # whoever calls this: the services' user has to read what is installed

usage() {
    cat <<'HELP'
usage: install.sh [agent] [mapserver] [options]

Installs the services that are named, the agent if none is: a Python environment in /opt/ommatidia, the command `ommatidia`, the user
`ommatidia`, udev rules, systemd units, and settings in /etc/ommatidia, where there are none yet. Run again, it updates all but the settings.

  --name NAME       what the robot is called in its settings (r1)
  --server E        where its map server listens (tcp/192.168.1.20:7447)
  --root DIR        install into a mounted image rather than into this machine
  --wheels DIR      take all Python packages from a folder, without a network
  --uninstall       remove everything but the settings
  --purge           with --uninstall: the settings and the user too

examples:
  sudo deploy/install.sh agent --name r2 --server tcp/192.168.1.20:7447
  sudo deploy/install.sh mapserver
  sudo deploy/install.sh --root /mnt/card agent --name r3
HELP
}

say() { echo "install.sh: $*"; }
fail() {
    say "$*" >&2
    exit 2
}

here=$(cd "$(dirname "$0")/.." && pwd)
root="" roles="" name=r1 server=tcp/192.168.1.20:7447 wheels="" action=install purge=no
while [ $# -gt 0 ]; do
    case $1 in
        agent | mapserver) roles="$roles $1" ;;
        --name | --server | --root | --wheels)
            [ $# -gt 1 ] || fail "$1 needs a value; see --help"
            case $1 in
                --name) name=$2 ;;
                --server) server=$2 ;;
                --root) root=${2%/} ;;
                --wheels) wheels=$2 ;;
            esac
            shift
            ;;
        --uninstall) action=uninstall ;;
        --purge) purge=yes ;;
        -h | --help)
            usage
            exit 0
            ;;
        *) fail "unknown argument $1; see --help" ;;
    esac
    shift
done
roles=${roles:-agent}

[ "$(id -u)" -eq 0 ] || fail "has to be run as root: sudo $0"
[ -e "$root/etc/debian_version" ] || fail "${root:-this machine} is no Debian and no Raspberry Pi OS: /etc/debian_version is missing"
[ -z "$wheels" ] || [ -d "$wheels" ] || fail "--wheels $wheels is no folder"

# Runs a command inside the image, or on this machine.
inside() {
    if [ -n "$root" ]; then chroot "$root" "$@"; else "$@"; fi
}
# Tells whether there is a running systemd to be told of changes.
is_live() { [ -z "$root" ] && [ -d /run/systemd/system ]; }

install_python() {
    inside python3 -c 'import ensurepip, venv' 2>/dev/null || {
        say "installing python3 and python3-venv"
        inside apt-get -q update
        inside apt-get -q -y --no-install-recommends install python3 python3-venv
    }
    inside python3 -c 'import sys; sys.exit(sys.version_info < (3, 11))' || fail "Python 3.11 is needed: Debian 12 or newer has it"
}

# Tells whether there is picamera2, which comes with the system alone.
has_picamera2() { [ -d "$root/usr/lib/python3/dist-packages/picamera2" ]; }

# The versions are those that ommatidia was tested with; a role gets only what it needs of them.
install_package() {
    say "installing ommatidia[$extras] into /opt/ommatidia"
    work=$(mktemp -d "$root/var/tmp/ommatidia.XXXXXX")
    trap 'rm -rf "$work"' EXIT
    mkdir "$work/source" "$work/wheels"
    (cd "$here" && tar -c --exclude=__pycache__ pyproject.toml README.md LICENSE agent deploy mapserver protocol sim) | tar -x -C "$work/source"
    sed -n 's/^\([A-Za-z0-9._-]*==[^ ;\\]*\).*/\1/p' "$here/requirements.lock" >"$work/versions"
    inner=${work#"$root"}
    set -- --quiet --disable-pip-version-check --no-input --constraint "$inner/versions" --prefer-binary
    if [ -n "$wheels" ]; then
        cp "$wheels"/*.whl "$work/wheels/"
        PIP_NO_INDEX=1 PIP_FIND_LINKS=$inner/wheels
        export PIP_NO_INDEX PIP_FIND_LINKS
    fi
    if has_picamera2; then
        inside python3 -m venv --system-site-packages /opt/ommatidia
        # The system's is built for NumPy 1, and breaks beside ours: https://github.com/raspberrypi/picamera2/issues/1088
        inside /opt/ommatidia/bin/python -m pip install "$@" --ignore-installed --no-deps "simplejpeg>=1.8.1"
    else
        inside python3 -m venv /opt/ommatidia
    fi
    inside /opt/ommatidia/bin/python -m pip install "$@" "$inner/source[$extras]"
    inside /opt/ommatidia/bin/python -m pip install "$@" --no-deps --force-reinstall "$inner/source[$extras]"
    rm -rf "$work"
    mkdir -p "$root/usr/local/bin"
    ln -sfn /opt/ommatidia/bin/ommatidia "$root/usr/local/bin/ommatidia"
}

install_user() {
    inside getent passwd ommatidia >/dev/null ||
        inside useradd --system --user-group --home-dir /nonexistent --no-create-home --shell /usr/sbin/nologin ommatidia
}

# Settings are the owner's: what is there stays.
install_settings() {
    mkdir -p "$root/etc/ommatidia"
    for role in $roles; do
        settings=$root/etc/ommatidia/$role.toml
        [ -e "$settings" ] || sed -e "s|^name = \"r1\"|name = \"$name\"|" -e "s|^endpoint = \"tcp/[^\"]*\"|endpoint = \"$server\"|" \
            "$here/deploy/config/$role.toml" >"$settings"
    done
    case $roles in *agent*)
        [ -e "$root/etc/ommatidia/sensor.yaml" ] || cp "$here/deploy/config/sensor.yaml" "$root/etc/ommatidia/sensor.yaml"
        ;;
    esac
}

install_units() {
    systemd=$root/etc/systemd/system
    mkdir -p "$systemd/multi-user.target.wants" "$root/etc/udev/rules.d" "$root/etc/modules-load.d"
    cp "$here/deploy/udev/70-ommatidia.rules" "$root/etc/udev/rules.d/"
    cp "$here/deploy/modules-load/ommatidia.conf" "$root/etc/modules-load.d/"
    version=$(inside systemctl --version 2>/dev/null | sed -n '1s/systemd \([0-9]*\).*/\1/p')
    for role in $roles; do
        unit=ommatidia-$role.service
        cp "$here/deploy/systemd/$unit" "$systemd/$unit"
        ln -sfn "/etc/systemd/system/$unit" "$systemd/multi-user.target.wants/$unit"
        if [ "${version:-0}" -ge 254 ]; then
            mkdir -p "$systemd/$unit.d"
            cp "$here/deploy/systemd/backoff.conf" "$systemd/$unit.d/backoff.conf"
        fi
    done
}

start() {
    is_live || {
        say "installed; the services start with the next boot"
        return
    }
    systemctl daemon-reload
    systemctl restart systemd-modules-load.service || say "some kernel modules of /etc/modules-load.d could not be loaded"
    udevadm control --reload && udevadm trigger --subsystem-match=tty --subsystem-match=video4linux
    for role in $roles; do
        systemctl restart "ommatidia-$role.service"
        say "ommatidia-$role runs; what it says: journalctl -fu ommatidia-$role; what is wrong: ommatidia doctor"
    done
}

uninstall() {
    for role in agent mapserver; do
        unit=ommatidia-$role.service
        if is_live && [ -e "/etc/systemd/system/$unit" ]; then systemctl stop "$unit"; fi
        rm -rf "$root/etc/systemd/system/$unit" "$root/etc/systemd/system/$unit.d" "$root/etc/systemd/system/multi-user.target.wants/$unit"
    done
    rm -rf "$root/opt/ommatidia" "$root/etc/udev/rules.d/70-ommatidia.rules" "$root/etc/modules-load.d/ommatidia.conf" \
        "$root/usr/local/bin/ommatidia"
    if is_live; then systemctl daemon-reload; fi
    if [ "$purge" = yes ]; then
        rm -rf "$root/etc/ommatidia"
        if inside getent passwd ommatidia >/dev/null; then inside userdel ommatidia; fi
    fi
    say "removed$([ "$purge" = yes ] || echo '; the settings in /etc/ommatidia are kept (--purge removes them)')"
}

if [ "$action" = uninstall ]; then
    uninstall
    exit 0
fi
case $roles in
    *agent*mapserver* | *mapserver*agent*) extras=agent,mapserver ;;
    *) extras=${roles# } ;;
esac
if is_live; then # nothing is to be read half old, half new
    for role in $roles; do systemctl stop "ommatidia-$role.service" 2>/dev/null || true; done
fi
install_python
install_package
install_user
install_settings
install_units
start
