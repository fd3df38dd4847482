# The simulated knob of foreign_target.pl: J θ'' + B θ' + K θ = torque - push - Coulomb friction, exact over small steps.
package foreign_knob;
use strict;
use warnings;
use constant { TAU => 8 * atan2(1, 1), STEPS => 16 };

sub new {
    my ($class, $native) = @_;
    my @numbers = (2.2e-6, 3.45e-4, 0.04, 0, 0.02, 0.001, 0.71, 0.1, 0);
    return bless { native => $native, numbers => \@numbers, push => [], grip => [], zero => 0 }, $class;
}

# Whether the bytes after a nonce can be those of SIMULATE.
sub fits {
    my ($rest) = @_;
    return 0 if length $rest < 74;
    my ($pushes, $grips) = unpack "x72CC", $rest;
    return $pushes <= 4 && $grips <= 4 && length $rest == 74 + 24 * ($pushes + $grips);
}

sub simulate {
    my ($self, $rest) = @_;
    my @numbers = unpack "(d<)9", $rest;
    my ($pushes, $grips) = unpack "x72CC", $rest;
    return 0 if $numbers[0] <= 0 || grep { $_ < 0 } @numbers[1 .. 3, 6, 7];
    my @sines = map { [ unpack "(d<)3", substr $rest, 74 + 24 * $_, 24 ] } 0 .. $pushes + $grips - 1;
    @$self{qw(numbers push grip)} = (\@numbers, [ @sines[0 .. $pushes - 1] ], [ @sines[$pushes .. $#sines] ]);
    return 1;
}

sub zero {
    my ($self, $angle) = @_;
    @$self{qw(x samples)} = ($self->{numbers}[4], undef);    # nobody holds it: it rests where it will when armed
    $self->{zero} += $angle - $self->angle;
    return 0;
}

# At rest, with nobody holding it, sampled every so many seconds.
sub arm {
    my ($self, $period) = @_;
    my @now = (period => $period, x => $self->{numbers}[4], v => 0, torque => 0, samples => undef, last => undef);
    %$self = (%$self, @now, flow => flow(@{ $self->{numbers} }[0 .. 2], $period / STEPS));
}

sub start { $_[0]{samples} = 0 }

# θ and θ' after h seconds, for each of θ, θ' and a torque: the exponential series of a short step, six halvings.
sub flow {
    my ($j, $b, $k, $h) = @_;
    my @a = ([ 0, 1, 0 ], [ -$k / $j, -$b / $j, 1 / $j ], [ 0, 0, 0 ]);
    my $scale = $h / 64;
    my @sum = map { my $i = $_; [ map { $_ == $i ? 1 : 0 } 0 .. 2 ] } 0 .. 2;
    my @term = map { [@$_] } @sum;
    for my $n (1 .. 12) {
        @term = product(\@term, \@a, $scale / $n);
        for my $i (0 .. 2) { $sum[$i][$_] += $term[$i][$_] for 0 .. 2 }
    }
    @sum = product(\@sum, \@sum, 1) for 1 .. 6;
    return [ @sum[0, 1] ];
}

sub product {
    my ($p, $q, $scale) = @_;
    return map { my $row = $_;
        [ map { my $c = $_; $scale * ($row->[0] * $q->[0][$c] + $row->[1] * $q->[1][$c] + $row->[2] * $q->[2][$c]) } 0 .. 2 ]
    } @$p;
}

sub sines {
    my ($t, $sines) = @_;
    my $sum = 0;
    $sum += $_->[0] * sin(TAU * $_->[1] * $t + $_->[2]) for @$sines;
    return $sum;
}

# Counts of the encoder at the next sample: the knob moves on by one period, whatever the time is.
sub angle {
    my ($self) = @_;
    $self->advance if defined $self->{samples} && $self->{samples}++ > 0;
    my $counts = $self->{x} / TAU * $self->{native};
    my $whole = int $counts;
    return $whole - ($whole > $counts ? 1 : 0) + $self->{zero};
}

sub advance {
    my ($self) = @_;
    my $push = $self->{numbers}[5] + sines(($self->{samples} - 2) * $self->{period}, $self->{push});
    my $drive = $self->{torque} - ($push > 0 ? $push : 0);
    my ($coulomb, $k, $flow) = (@{ $self->{numbers} }[3, 2], $self->{flow});
    my ($x, $v) = @$self{qw(x v)};
    for (1 .. STEPS) {
        my $sum = $drive - $k * $x;
        next if $coulomb > 0 && $v == 0 && abs($sum) <= $coulomb;
        my $sign = $v > 0 || ($v == 0 && $sum > 0) ? 1 : -1;
        my $u = $drive - $coulomb * $sign;
        my @next = map { $_->[0] * $x + $_->[1] * $v + $_->[2] * $u } @$flow;
        $next[1] = 0 if $coulomb > 0 && $next[1] * $sign < 0;
        ($x, $v) = @next;
    }
    @$self{qw(x v)} = ($x, $v);
}

sub torque { $_[0]{torque} = $_[1] }

sub grip {
    my ($self) = @_;
    my (undef, undef, undef, undef, undef, undef, $grip, $rise, $offset) = @{ $self->{numbers} };
    return $offset if !defined $self->{samples};
    my $t = ($self->{samples} - 1) * $self->{period};
    my $held = $grip * ($rise > 0 ? 1 - exp(-$t / $rise) : 1) + sines($t, $self->{grip});
    return $held + $offset;
}

sub speed_since_last {
    my ($self, $period) = @_;
    my $last = $self->{last} // $self->{x};
    $self->{last} = $self->{x};
    return abs($self->{x} - $last) / $period;
}

1;
