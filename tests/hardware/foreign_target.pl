#!/usr/bin/perl
# A target in another language, written from docs/reference/wire.md alone: frames, commands, sample clock and a simulated knob.
#
#   perl foreign_target.pl [--fault NAME] [--no-grip-cell] [--native N] [--slack FACTOR]
#
# Serves one host at a time on a TCP port of this computer alone, prints the port's URL as its first line, and ends when
# its standard input does. --fault: one of the faults in %FAULTS, each a thing that a real target might do wrong. --slack:
# by how much longer it waits for the host than it should, where the computer is busy with other things.
use strict;
use warnings;
use FindBin;
use lib $FindBin::Bin;
use foreign_knob;
use Getopt::Long;
use IO::Select;
use IO::Socket::INET;
use Time::HiRes qw(clock_gettime CLOCK_MONOTONIC);

use constant { HELLO => 1, CONFIGURE => 2, ARM => 3, START => 4, STOP => 5, RELEASE => 6, ALIVE => 7, AGAIN => 8,
    ZERO => 9, SIMULATE => 16, CONTROL => 17, ACK => 0x81, BLOCK => 0x82, EVENT => 0x83 };
use constant { DONE => 0, NOT_NOW => 1, OUT_OF_RANGE => 2, NOT_KNOWN => 3 };
use constant { IDLE => 0, ARMED => 1, RUNNING => 2, TRIPPED => 3 };
use constant { NO_FAULT => 0, WATCHDOG => 1, SPEED => 2, NOT_A_NUMBER => 3, NO_ROOM => 5 };
use constant { SIMULATED => 1, NO_GRIP_CELL => 2, KNOWS_ZERO => 8 };
use constant { ROOM_S => 0.25, TAU => 8 * atan2(1, 1), EVENT_EVERY_S => 0.02 };

my %FAULTS = map { $_ => 1 } qw(
    keeps-torque keeps-torque-in-secret refuses-release stop-keeps-running arms-at-once
    no-wall-flag loses-wall-flag wall-flag-too-early torque-while-armed
    ms-clock half-stamps stamps-2-percent-fast
    loop-at-half-rate loop-at-half-rate-unsaid clock-2-percent-fast clock-2-percent-slow
    half-torque other-counts wrong-sign no-torque-limit stale-torque
    nan-torque nan-grip all-crcs-wrong block-crcs-wrong
    nan-echo other-echo restarts falls-silent repeats-samples trips-by-speed);
my ($fault, $no_grip_cell, $native, $slack) = ("", 0, 16384, 1);
GetOptions("fault=s" => \$fault, "no-grip-cell" => \$no_grip_cell, "native=i" => \$native, "slack=f" => \$slack)
    or die "options\n";
die "no such fault: $fault\n" if $fault && !$FAULTS{$fault};

# Frames: COBS of body and CRC-32, and a zero byte.
my @CRC = map { my $c = $_; $c = $c & 1 ? 0xEDB88320 ^ ($c >> 1) : $c >> 1 for 1 .. 8; $c } 0 .. 255;

sub crc {
    my $c = 0xFFFFFFFF;
    $c = $CRC[($c ^ $_) & 255] ^ ($c >> 8) for unpack "C*", $_[0];
    return $c ^ 0xFFFFFFFF;
}

sub stuffed {
    my ($left) = @_;
    my $out = "";
    while (1) {
        my ($run) = $left =~ /^([^\0]{0,254})/;
        substr($left, 0, length $run) = "";
        $out .= chr(1 + length $run) . $run;
        return $out if $left eq "";
        substr($left, 0, 1) = "" if length $run < 254;    # the zero byte that this run stands for
    }
}

sub unstuffed {
    my ($data) = @_;
    my ($out, $at) = ("", 0);
    while ($at < length $data) {
        my $code = ord substr $data, $at, 1;
        return undef if $code == 0 || $at + $code > length $data;
        $out .= substr $data, $at + 1, $code - 1;
        $at += $code;
        $out .= "\0" if $code < 255 && $at < length $data;
    }
    return $out;
}

sub frame {
    my ($type, $rest) = @_;
    my $body = pack("CC", 1, $type) . $rest;
    my $crc = crc($body);
    $crc ^= 0x5A5A5A5A if $fault eq "all-crcs-wrong" || ($fault eq "block-crcs-wrong" && $type == BLOCK);
    return stuffed($body . pack "V", $crc) . "\0";
}

sub body_of {
    my $checked = unstuffed($_[0]);
    return undef if !defined $checked || length $checked < 6;
    my $body = substr $checked, 0, -4;
    return crc($body) == unpack("V", substr $checked, -4) && ord($body) == 1 ? $body : undef;
}

# The target.
my %self = (state => IDLE, fault => NO_FAULT, boot => int(rand 2**32), made => [], forgotten => 0);
my $knob = foreign_knob->new($native);
my $keeps = $fault =~ /^keeps-torque|^refuses-release/;    # the loop goes on after STOP, and RELEASE changes nothing
my ($client, $in, $out, $carried_out, $last_ack);

sub now { return clock_gettime(CLOCK_MONOTONIC) }

sub in_range {
    my ($period, $counts, $k, $b, $torque, $speed, $watchdog, $block) = @_;
    for ($k, $b) { return 0 unless $_ >= 0 && $_ <= 1e3 }
    return $period >= 50_000 && $period <= 1e9 && $counts >= 1 && $counts <= $native && $torque > 0 && $torque <= 10
        && $speed > 0 && $speed <= 1e4 && $watchdog >= 1000 && $watchdog <= 50_000 && $block >= 1 && $block <= 48;
}

sub arm {
    my ($nonce) = @_;
    return NOT_NOW if $self{state} != IDLE || !$self{settings};
    @self{qw(run state armed_at taken first_on pending made forgotten before heard_at)} =
        ($nonce, ARMED, now(), 0, undef, [], [], 0, undef, now());
    $self{first_on} = 0, $self{state} = RUNNING if $fault eq "arms-at-once";
    $knob->arm($self{settings}[0] * 1e-9);
    return DONE;
}

sub carry_out {
    my ($type, $nonce, $rest) = @_;
    return DONE if $type == HELLO;
    if ($type == CONFIGURE) {
        my @values = unpack "VVd<d<d<d<Vv", $rest;
        return NOT_NOW if $self{state} != IDLE;
        return OUT_OF_RANGE if !in_range(@values);
        $self{settings} = \@values;
        return DONE;
    }
    return $self{state} != IDLE ? NOT_NOW : $knob->simulate($rest) ? DONE : OUT_OF_RANGE if $type == SIMULATE;
    return arm($nonce) if $type == ARM;
    return $self{state} != IDLE ? NOT_NOW : $knob->zero(unpack "l<", $rest) if $type == ZERO;
    if ($type == START) {
        return NOT_NOW if $self{state} != ARMED;
        @self{qw(state first_on)} = (RUNNING, $self{taken});
        $knob->start;
        return DONE;
    }
    if ($type == STOP) {
        return NOT_NOW if $self{state} != ARMED && $self{state} != RUNNING;
        return DONE if $fault eq "stop-keeps-running";
        send_block() if @{ $self{pending} };
        $self{hidden} = $keeps;
        $self{state} = IDLE if !$keeps;
        return DONE;
    }
    if ($type == RELEASE) {
        my $on = $self{state} == RUNNING;
        $self{hidden} = 0;
        return NOT_NOW if $on && $fault eq "refuses-release";
        return DONE if $on && $keeps;
        @self{qw(state fault made pending event)} = (IDLE, NO_FAULT, [], [], undef);
        return DONE;
    }
    return NOT_KNOWN;
}

my %LENGTH = (HELLO, 0, CONFIGURE, 46, ARM, 0, START, 0, STOP, 0, RELEASE, 0, ALIVE, 4, AGAIN, 6, ZERO, 4);

sub obey {
    my ($body) = @_;
    return if length $body < 6;
    my ($type, $nonce) = unpack "xCV", $body;
    my $rest = substr $body, 6;
    return if !exists $LENGTH{$type} && $type != SIMULATE && $type != CONTROL;
    return if $type == CONTROL ? length $rest < 4 : $type != SIMULATE ? length $rest != $LENGTH{$type} : !foreign_knob::fits($rest);
    $self{heard_at} = now();
    if ($type == ALIVE) {
        my $expected = unpack "V", $rest;
        $self{forgotten} = $expected if $expected > $self{forgotten} && $expected <= @{ $self{made} };
    } elsif ($type == AGAIN) {
        my ($first, $count) = unpack "Vv", $rest;
        $out .= $self{made}[$_] // "" for grep { $_ < @{ $self{made} } } $first .. $first + $count - 1;
    } else {
        if (!defined $carried_out || $carried_out != $nonce) {
            my $status = carry_out($type, $nonce, $rest);
            ($carried_out, $last_ack) = ($nonce, ack($type, $nonce, $status, $rest));
        }
        $out .= $last_ack;
    }
}

sub ack {
    my ($type, $nonce, $status, $rest) = @_;
    my $secret = ($fault eq "keeps-torque-in-secret" && $type == RELEASE) || $self{hidden};
    my $state = $secret ? IDLE : $self{state};
    my $said = "";
    my $flags = SIMULATED | KNOWS_ZERO | ($no_grip_cell ? NO_GRIP_CELL : 0);
    $said = pack "VVCa16", $native, 50_000, $flags, "perl" if $type == HELLO;
    if (($type == CONFIGURE || $type == SIMULATE || $type == ZERO) && $status == DONE) {
        $said = $rest;
        substr($said, 8, 8) = pack "d<", 9**9**9 / 9**9**9 if $fault eq "nan-echo" && $type == CONFIGURE;
        substr($said, 4, 4) = pack "V", 77 if $fault eq "other-echo" && $type == CONFIGURE;
    }
    return frame(ACK, pack("VCCCCVV", $nonce, $type, $status, $state, $self{fault}, $self{boot},
            scalar @{ $self{made} }) . $said);
}

# How long a period really lasts on this target's clock, and what it says of the time of a sample.
sub interval_s {
    my $told = $self{settings}[0] * 1e-9;
    return 2 * $told if $fault =~ /^loop-at-half-rate/;
    return $told / 1.02 if $fault eq "clock-2-percent-fast";
    return $told / 0.98 if $fault eq "clock-2-percent-slow";
    return $told;
}

sub stamp_us {
    my ($index) = @_;
    my $us = $index * $self{settings}[0] * 1e-3;
    $us *= 2 if $fault eq "loop-at-half-rate";
    $us *= 0.5 if $fault eq "half-stamps";
    $us *= 1.02 if $fault eq "stamps-2-percent-fast";
    $us = 1000 * int($us / 1000) if $fault eq "ms-clock";
    return int $us;
}

sub wall {
    my ($angle) = @_;
    my ($period, $counts, $k, $b, $limit) = @{ $self{settings} };
    $counts *= 2 if $fault eq "other-counts";
    use integer;
    my $d = ($angle * $counts - (($angle * $counts) % $native + $native) % $native) / $native;
    no integer;
    my $before = $self{before} // $d;
    $self{before} = $d;
    return 0 if $self{state} != RUNNING || $d >= 0;
    my $quantum = TAU / $counts;
    my $torque = -$k * ($d * $quantum) - $b * (($d - $before) * $quantum) / ($period * 1e-9);
    $torque *= 0.5 if $fault eq "half-torque";
    $torque = -$torque if $fault eq "wrong-sign";
    $limit *= 1e3 if $fault eq "no-torque-limit";
    return $torque > $limit ? $limit : $torque < -$limit ? -$limit : $torque;
}

sub sample {
    my $index = $self{taken}++;
    my $angle = $knob->angle;
    my $torque = wall($angle);
    my $on = $self{state} == RUNNING && $fault ne "no-wall-flag";
    my $since = $self{state} == RUNNING ? $index - $self{first_on} : -1;
    $on = 0 if $fault eq "loses-wall-flag" && $since > 50;
    $on = 1 if $fault eq "wall-flag-too-early";
    my $said = $fault eq "stale-torque" ? $self{said} // 0 : $torque;
    $self{said} = $torque;
    $said = 1e-3 if $fault eq "torque-while-armed" && $since < 0;
    $said = 9**9**9 / 9**9**9 if $fault eq "nan-torque" && $since == 100;
    my $grip = $no_grip_cell ? 0 : $knob->grip;
    $grip = 9**9**9 / 9**9**9 if $fault eq "nan-grip" && $since == 100;
    push @{ $self{pending} }, pack "Vl<f<f<C", stamp_us($index), $angle, $said, $grip, $on ? 1 : 0;
    $knob->torque($torque);
    send_block() if @{ $self{pending} } >= $self{settings}[7];
    my $speed = $knob->speed_since_last($self{settings}[0] * 1e-9);
    trip(SPEED, $index) if $speed > $self{settings}[5] || ($fault eq "trips-by-speed" && $since == 100);
    if ($since == 100 && $fault eq "restarts") {
        @self{qw(state fault made pending boot)} = (IDLE, NO_FAULT, [], [], $self{boot} ^ 0x5555);
    }
}

sub send_block {
    my $pending = $self{pending};
    my $first = $self{taken} - @$pending;
    my $block = frame(BLOCK, pack("VVVVVC", $self{boot}, $self{run}, scalar @{ $self{made} }, $first, 0,
            scalar @$pending) . join "", @$pending);
    push @{ $self{made} }, $block;
    $self{pending} = [];
    my $silent = $fault eq "falls-silent" && @{ $self{made} } > 20;
    $out .= $block if !$silent && !$self{hidden};
    $out .= $block if $fault eq "repeats-samples";
}

sub trip {
    my ($why, $index) = @_;
    send_block() if @{ $self{pending} };
    @self{qw(state fault)} = (TRIPPED, $why);
    $self{event} = frame(EVENT, pack "VVCVVV", $self{boot}, $self{run}, $why, $index, stamp_us($index),
        scalar @{ $self{made} });
    $self{event_at} = 0;
}

sub go_on {
    my $now = now();
    while (($self{state} == ARMED || $self{state} == RUNNING)
        && $self{armed_at} + $self{taken} * interval_s() <= $now) {
        sample();
    }
    if ($self{state} == ARMED || $self{state} == RUNNING) {
        my $kept = (@{ $self{made} } - $self{forgotten}) * $self{settings}[7] * $self{settings}[0] * 1e-9;
        trip(WATCHDOG, $self{taken}) if !$keeps && $now - $self{heard_at} > $slack * $self{settings}[6] * 1e-6;
        trip(NO_ROOM, $self{taken}) if !$keeps && $self{state} != TRIPPED && $kept > $slack * ROOM_S;
    }
    if ($self{state} == TRIPPED && $now - $self{event_at} >= EVENT_EVERY_S) {
        $self{event_at} = $now;
        $out .= $self{event};
    }
}

my $server = IO::Socket::INET->new(Listen => 1, LocalAddr => "127.0.0.1", Proto => "tcp") or die "no port: $!\n";
$| = 1;
print "socket://127.0.0.1:", $server->sockport, "\n";
($in, $out) = ("", "");
while (1) {
    my $reading = IO::Select->new(\*STDIN, $client // $server);
    for my $ready ($reading->can_read($self{state} == IDLE ? 0.05 : 0.0005)) {
        if ($ready == \*STDIN) {
            exit 0 if !sysread STDIN, my $ignored, 64;
        } elsif ($ready == $server) {
            $client = $server->accept;
            $client->blocking(0);
            ($in, $out) = ("", "");
        } elsif (!sysread $client, $in, 65536, length $in) {
            close $client;
            undef $client;
            last;
        }
    }
    while ($in =~ s/^([^\0]*)\0//) {
        my $body = length $1 ? body_of($1) : undef;
        obey($body) if defined $body;
    }
    go_on();
    if ($client && length $out) {
        my $written = syswrite $client, $out;
        substr($out, 0, $written) = "" if $written;
    }
}
